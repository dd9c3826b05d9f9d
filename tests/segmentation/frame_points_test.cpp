// The bony points of ISB frames: found in scans of phantoms, against the phantoms' bones; found in the ICRP
// male, against his labels.
#include "segmentation/joints/frame_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "samples/phantom_voxels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/paths.hpp"

namespace borelli::frame_points_test {
namespace {

using Eigen::Vector3d;

const std::vector<std::string> stems{"psis",         "ulnar_styloid", "radial_styloid",
                                     "metatarsal_1", "metatarsal_2",  "metatarsal_5"};

std::vector<std::string> names() {
  std::vector<std::string> all{"t8"};
  for (const std::string& stem : stems)
    for (const char* side : {"_left", "_right"}) all.push_back(stem + side);
  return all;
}

struct Body {
  const char* name;
  PhantomOptions options;
  Vector3d spacing;
  double noise = 0;
};

PhantomOptions woman() {
  PhantomOptions options;
  options.sex = Sex::female;
  return options;
}

PhantomOptions drawn(std::uint64_t seed) {
  PhantomOptions options;
  options.variation = seed;
  options.sex = seed % 2 ? Sex::male : Sex::female;
  return options;
}

Segmentation found_in(const GreyVolume& volume, Landmarks given = {}) {
  SegmentOptions options;
  options.given = std::move(given);
  auto found = segment(volume, options);
  EXPECT_TRUE(found) << found.error().message();
  return found ? *found : Segmentation{};
}

// Per name, over all bodies: the root mean square of the coordinates' errors is within the stated deviation,
// and no error exceeds its double.
void expect_points_within_their_deviations(const std::vector<Body>& bodies) {
  std::map<std::string, double> squares;
  std::map<std::string, int> cases;
  for (const Body& body : bodies) {
    const Phantom phantom = build_phantom(body.options).value();
    GridOptions grid;
    grid.spacing = body.spacing;
    const Scan scan =
        voxelise(phantom, phantom_grid(phantom, grid), {.partial_volume = true, .noise_hu = body.noise});
    const Segmentation found = found_in(scan.grey);
    for (const std::string& name : names()) {
      const auto mark = found.landmarks.find(name);
      ASSERT_NE(mark, found.landmarks.end()) << name << " in " << body.name;
      const Vector3d error = mark->second.point - phantom.landmarks.at(name).point;
      EXPECT_LT(error.cwiseAbs().maxCoeff(), 2 * mark->second.deviation) << name << " in " << body.name;
      const auto side = std::min(name.rfind("_left"), name.rfind("_right"));
      const std::string stem = name.substr(0, side);
      squares[stem] += (error / mark->second.deviation).squaredNorm() / 3;
      ++cases[stem];
    }
  }
  for (const auto& [stem, sum] : squares) {
    std::printf("%-16s rms %.2f of its deviation\n", stem.c_str(), std::sqrt(sum / cases[stem]));
    EXPECT_LT(std::sqrt(sum / cases[stem]), 1) << stem;
  }
}

TEST(FramePoints, LieWithinTheirDeviationsInTwoPhantoms) {
  expect_points_within_their_deviations({{"woman, 3 mm", woman(), Vector3d::Constant(3), 20},
                                         {"drawn, 3 x 3 x 4 mm", drawn(3), Vector3d(3, 3, 4), 15}});
}

TEST(FramePoints, LieWithinTheirDeviationsInFivePhantoms) {
  expect_points_within_their_deviations({{"man, 2 mm", {}, Vector3d::Constant(2), 20},
                                         {"woman, 3 mm", woman(), Vector3d::Constant(3), 20},
                                         {"man, 1.5 x 1.5 x 4 mm", {}, Vector3d(1.5, 1.5, 4), 10},
                                         {"drawn, 2.5 mm", drawn(3), Vector3d::Constant(2.5), 15},
                                         {"drawn, 2.5 mm", drawn(8), Vector3d::Constant(2.5), 15}});
}

// Forearms that lie on each other in front of the belly: the radius is the thicker of the same arm's two
// bones.
TEST(FramePoints, LieOnTheStyloidsOfTouchingForearms) {
  int shown = 0;
  for (const std::uint64_t variation : {5201, 5303, 8001}) {
    PhantomOptions options;
    options.variation = variation;
    for (const std::string side : {"_left", "_right"}) {
      options.pose_deg["shoulder" + side + "_flexion"] = 25;
      options.pose_deg["shoulder" + side + "_abduction"] = 10;
      options.pose_deg["shoulder" + side + "_rotation"] = 70;
      options.pose_deg["elbow" + side + "_flexion"] = side == "_left" ? 80 : 70;
    }
    const Phantom phantom = build_phantom(options).value();
    GridOptions grid;
    grid.spacing = Vector3d::Constant(3);
    const Scan scan = voxelise(phantom, phantom_grid(phantom, grid), {.noise_hu = 12});
    const Segmentation found = found_in(scan.grey);
    for (const char* stem : {"ulnar_styloid", "radial_styloid"})
      for (const char* side : {"_left", "_right"}) {
        const Vector3d exact = phantom.landmarks.at(stem + std::string(side)).point;
        // the other arm's flesh may reach into this bone, so that the scan does not show its end
        const Vector3d index = scan.labels.grid.index(exact);
        const int part = scan.labels.at(std::lround(index[0]), std::lround(index[1]), std::lround(index[2]));
        if (!parts[static_cast<std::size_t>(part)].name.ends_with(side)) continue;
        ++shown;
        const auto mark = found.landmarks.find(stem + std::string(side));
        ASSERT_TRUE(mark != found.landmarks.end()) << variation << stem << side;
        EXPECT_LT((mark->second.point - exact).cwiseAbs().maxCoeff(), 2 * mark->second.deviation)
            << variation << stem << side;
      }
  }
  EXPECT_GE(shown, 9);  // of twelve points
}

// Points that the scan does not show are missing; points given by hand stay.
TEST(FramePoints, AreFoundIfVisibleAndYieldToGivenPoints) {
  const Phantom phantom = build_phantom({}).value();
  GridOptions grid;
  grid.spacing = Vector3d::Constant(3);
  grid.crop_low[2] = phantom.landmarks.at("knee_left").point[2];  // no feet
  const Scan scan = voxelise(phantom, phantom_grid(phantom, grid));
  const Landmark t8{Vector3d(3, 120, 1300), 1, 0, "given"};
  const Landmark psis{Vector3d(40, 80, 1010), 1, 0, "given"};
  const Segmentation found = found_in(scan.grey, {{"t8", t8}, {"psis_left", psis}});
  for (const char* side : {"_left", "_right"}) {
    for (const char* stem : {"metatarsal_1", "metatarsal_2", "metatarsal_5"})
      EXPECT_FALSE(found.landmarks.contains(std::string(stem) + side)) << stem << side;
    EXPECT_TRUE(found.landmarks.contains(std::string("ulnar_styloid") + side));
  }
  EXPECT_EQ(found.landmarks.at("t8").point, t8.point);
  EXPECT_EQ(found.landmarks.at("psis_left").point, psis.point);
  EXPECT_LT((found.landmarks.at("psis_right").point - phantom.landmarks.at("psis_right").point).norm(), 14);
}

// The ICRP male, on slices of 8 mm. His pelvis has its own label, so its rearmost point beside the sacrum is
// known; his thoracic spine is known from its top to its lowest disc.
TEST(FramePoints, MatchTheIcrpMale) {
  const std::string folder = test::shared_folder() + "/volumes/icrp_am/";
  if (!std::filesystem::exists(folder + "AM_hu.nii.gz"))
    GTEST_SKIP() << "the ICRP male is not beside the checkout";
  const GreyVolume hu = read_volume(folder + "AM_hu.nii.gz")->volume,
                   organs =
                       read_volume(folder + "AM_labels.nii.gz", {.quantity = FileQuantity::labels})->volume;
  const Segmentation found = found_in(hu);
  const double middle =
      0.5 * (found.landmarks.at("hip_left").point[0] + found.landmarks.at("hip_right").point[0]);
  const Grid& g = organs.grid;
  Vector3d left(0, -1e9, 0), right(0, -1e9, 0);
  double low = 1e9, high = -1e9, notch = -1e9;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const int organ = organs.at(i, j, k);
        const Vector3d p = g.point(i, j, k);
        if (organ == 41 || organ == 42) {
          Vector3d& last = p[0] > middle ? left : right;
          if (p[1] > last[1] && p[2] > found.landmarks.at("hip_left").point[2]) last = p;
        }
        if (organ == 55) notch = std::max(notch, p[2]);
        if (organ == 49 || organ == 50) low = std::min(low, p[2]), high = std::max(high, p[2]);
      }
  for (const auto& [name, labelled] : {std::pair{"psis_left", left}, {"psis_right", right}}) {
    const Landmark& mark = found.landmarks.at(name);
    EXPECT_LT((mark.point - labelled).cwiseAbs().maxCoeff(), 2 * mark.deviation)
        << name << " " << mark.point.transpose() << ", labelled " << labelled.transpose();
  }
  // eight of twelve vertebrae, whose heights grow from top to bottom: 0.57 to 0.667 of the way
  const Landmark& t8 = found.landmarks.at("t8");
  EXPECT_NEAR((high - t8.point[2]) / (high - low), 0.62, 0.05);
  EXPECT_GT(t8.deviation, 12);  // no disc is visible
  // by CT numbers only the manubrium's cortex is bone; reference: its labelled top
  EXPECT_NEAR(found.landmarks.at("suprasternale").point[2], notch, 11);
}

// Two real pelves, the second turned by 7 degrees. Reference: the posterior end of the iliac wing, read by
// eye to a few mm. No other point of the frames is in view.
TEST(FramePoints, MatchRealPelves) {
  struct Pelvis {
    std::string path;
    std::optional<FileQuantity> quantity;
    Vector3d left, right;
  };
  const std::string folder = test::shared_folder() + "/volumes/";
  for (const Pelvis& pelvis :
       {Pelvis{folder + "ct_abdomen_3mm.nii.gz", FileQuantity::hu, {50, -58, 227}, {-55, -59, 227}},
        Pelvis{folder + "ct_trunk_dicom", std::nullopt, {30, 125, 1206}, {-70, 116, 1199}}}) {
    if (!std::filesystem::exists(pelvis.path)) GTEST_SKIP() << pelvis.path << " is not there";
    const auto scan = read_volume(pelvis.path, {.quantity = pelvis.quantity});
    ASSERT_TRUE(scan) << scan.error().message();
    const Segmentation found = found_in(scan->volume);
    EXPECT_LT((found.landmarks.at("psis_left").point - pelvis.left).norm(), 6) << pelvis.path;
    EXPECT_LT((found.landmarks.at("psis_right").point - pelvis.right).norm(), 6) << pelvis.path;
    for (const std::string& name : names())
      if (!name.starts_with("psis")) {
        EXPECT_FALSE(found.landmarks.contains(name)) << name;
      }
  }
}

}  // namespace
}  // namespace borelli::frame_points_test
