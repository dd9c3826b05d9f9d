// Joints on grids whose voxels are as large as the gap between two bones, against the phantom's exact ones.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli::coarse_grids_test {
namespace {

struct Body {
  std::optional<std::uint64_t> variation;
  Sex sex;
  double step;  // of the work grid, mm
};

struct Scanned {
  Phantom body;
  Scan scan;
  Segmentation found;
};

Scanned scanned(const Body& how) {
  PhantomOptions of;
  of.variation = how.variation, of.sex = how.sex;
  Phantom body = build_phantom(of).value();
  GridOptions grid;
  grid.spacing = Eigen::Vector3d::Constant(5);
  Scan scan = voxelise(body, phantom_grid(body, grid));
  SegmentOptions options;
  options.step = how.step;
  Segmentation found = segment(scan.grey, options).value();
  return {std::move(body), std::move(scan), std::move(found)};
}

class CoarseGrids : public testing::TestWithParam<Body> {};

// Voxels of 5 mm take the tissue at their centre, so small bones break up and a forearm's sections jump. In
// such scans a wrist was once found beyond the carpus (29 to 45 mm too far down) or in the shaft.
TEST_P(CoarseGrids, WristsLieInFrontOfTheCarpus) {
  const auto [body, scan, found] = scanned(GetParam());
  const double step = GetParam().step;
  std::array<double, parts.size()> here{}, exact{};  // voxels by label
  for (std::size_t o = 0; o < scan.labels.voxels.size(); ++o)
    ++here[found.labels.voxels[o]], ++exact[scan.labels.voxels[o]];
  for (const std::string side : {"_left", "_right"}) {
    const Landmark& wrist = found.landmarks.at("wrist" + side);
    const double off = (wrist.point - body.landmarks.at("wrist" + side).point).norm();
    EXPECT_LT(off, step) << side;
    EXPECT_LT(off, 2 * wrist.deviation) << side;
    // a cut of about 20 cm2 that is one voxel off changes hands of 350 to 450 ml by 2 %; README states 5 %
    const auto hand = static_cast<std::size_t>(part_label("hand" + side));
    EXPECT_NEAR(here[hand] / exact[hand], 1, 0.05) << side;
  }
}

// In this scan a cylinder at the tibia's end was once taken for condyles, 42 mm too far down with a deviation
// of 4.5.
TEST(CoarseGrid, KneesAreNotBelowTheJointLine) {
  const auto [body, scan, found] = scanned({2, Sex::female, 3});
  for (const char* name : {"knee_left", "knee_right", "knee_medial_left", "knee_medial_right",
                           "knee_lateral_left", "knee_lateral_right"}) {
    const Landmark& mark = found.landmarks.at(name);
    const double off = (mark.point - body.landmarks.at(name).point).norm();
    EXPECT_LT(off, 2 * mark.deviation) << name;
    EXPECT_LT(off, 10) << name;  // two voxels; half the way to the shank's end
  }
}

// In this scan the shaft was once taken for the trochlea, 15 mm too far up with a deviation of 3.1. The
// larger deviations on such voxels must be stated.
TEST(CoarseGrid, ElbowsAreNotInTheShaft) {
  const auto [body, scan, found] = scanned({std::nullopt, Sex::male, 5});
  for (const char* name : {"elbow_left", "elbow_right", "elbow_medial_left", "elbow_medial_right",
                           "elbow_lateral_left", "elbow_lateral_right"}) {
    const double off = (found.landmarks.at(name).point - body.landmarks.at(name).point).norm();
    EXPECT_LT(off, 5) << name;  // a voxel
  }
  for (const char* name : {"psis_left", "psis_right", "t8", "neck", "medial_malleolus_left",
                           "medial_malleolus_right", "elbow_left", "elbow_right"}) {
    const Landmark& mark = found.landmarks.at(name);
    EXPECT_LT((mark.point - body.landmarks.at(name).point).norm(), 2 * mark.deviation) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, CoarseGrids,
                         testing::Values(Body{std::nullopt, Sex::male, 4.5}, Body{1, Sex::male, 4.5},
                                         Body{2, Sex::female, 4}, Body{3, Sex::male, 5}),
                         [](const auto& made) {
                           const Body& body = made.param;
                           return (body.variation ? "Variation" + std::to_string(*body.variation) : "Usual") +
                                  "At" + std::to_string(std::lround(10 * body.step));
                         });

}  // namespace
}  // namespace borelli::coarse_grids_test
