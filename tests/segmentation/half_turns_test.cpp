// Bodies whose header is wrong by half a turn.
#include "segmentation/joints/half_turns.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/segmentation/dice.hpp"

namespace borelli::half_turns_test {
namespace {

Segmentation found_in(const GreyVolume& volume) {
  SegmentOptions options;
  options.step = 4;
  auto found = segment(volume, options);
  EXPECT_TRUE(found) << found.error().message();
  return found ? *found : Segmentation{};
}

// The same voxels with a header that is half a turn off about one of the patient's axes: parts and landmarks
// equal those with the right header, and a warning reports the contradiction and uncertain sides.
TEST(HalfTurns, BodyOverridesAWrongHeader) {
  const Phantom body = *build_phantom({});
  GridOptions coarse;
  coarse.spacing.setConstant(4);
  const Scan scan = voxelise(body, phantom_grid(body, coarse), {.noise_hu = 15});
  const auto contradicts = [](const Segmentation& found) {
    return std::ranges::count_if(found.warnings, [](const Warning& warning) {
      return warning.text.starts_with("the header contradicts the body");
    });
  };
  const Segmentation right = found_in(scan.grey);
  EXPECT_EQ(contradicts(right), 0);
  for (const Eigen::Vector3d& signs : std::vector<Eigen::Vector3d>{{-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}}) {
    GreyVolume turned = scan.grey;
    turned.grid.axes = signs.asDiagonal() * turned.grid.axes;
    turned.grid.origin = signs.asDiagonal() * turned.grid.origin;
    const Segmentation found = found_in(turned);
    ASSERT_EQ(contradicts(found), 1) << signs.transpose();
    EXPECT_EQ(found.labels.grid, turned.grid);
    const auto agreement = dice(found.labels, scan.labels), straight = dice(right.labels, scan.labels);
    for (std::size_t n = 1; n < parts.size(); ++n) {
      EXPECT_GT(agreement[n], straight[n] - 0.01) << parts[n].name << signs.transpose();
      EXPECT_EQ(found.part[n].coverage, Coverage::whole) << parts[n].name;
      const bool sided = parts[n].name.ends_with("_left") || parts[n].name.ends_with("_right");
      EXPECT_EQ(found.part[n].confidence < 0.5, sided) << parts[n].name;
    }
    for (const char* name : {"hip_left", "shoulder_right", "knee_left", "neck"})
      EXPECT_LT((signs.asDiagonal() * found.landmarks.at(name).point - right.landmarks.at(name).point).norm(),
                2)
          << name << signs.transpose();
  }
}

// A scan of the pelvis alone, whose header calls the front back.
TEST(HalfTurns, PubisTellsFrontFromBack) {
  const Phantom body = *build_phantom({});
  GridOptions coarse;
  coarse.spacing.setConstant(4);
  Grid grid = phantom_grid(body, coarse);
  const double hips = body.landmarks.at("mid_hip").point.z();
  const auto first = std::lround((hips - 120 - grid.origin.z()) / 4),
             last = std::lround((hips + 100 - grid.origin.z()) / 4);
  grid.origin.z() += 4 * double(first), grid.size[2] = last - first;
  GreyVolume pelvis = voxelise(body, grid, {.noise_hu = 15}).grey;
  Trunk trunk = find_trunk(anatomy_of(pelvis, 4, 1));
  ASSERT_TRUE(trunk.hip[0] && trunk.hip[1]);
  EXPECT_FALSE(half_turn(anatomy_of(pelvis, 4, 1), trunk));
  const Eigen::Vector3d signs(-1, -1, 1);
  pelvis.grid.axes = signs.asDiagonal() * pelvis.grid.axes;
  pelvis.grid.origin = signs.asDiagonal() * pelvis.grid.origin;
  std::swap(trunk.hip[0], trunk.hip[1]);
  for (auto& hip : trunk.hip) hip->centre = signs.asDiagonal() * hip->centre;
  const auto found = half_turn(anatomy_of(pelvis, 4, 1), trunk);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->isApprox(Eigen::Matrix3d(signs.asDiagonal())));
}

}  // namespace
}  // namespace borelli::half_turns_test
