// Cut lines in pictures, for limbs whose planes are known in closed form.
#include "pipeline/export/cut_lines.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

const std::vector<std::string> names{"outside", "shank_left", "thigh_left", "hand_left"};  // own order

/// A thigh and shank as one rod of radius 40 mm along `axis` through `knee`, separated by the plane with
/// `normal`.
struct Leg {
  Thumbnail copy;
  Cut cut;

  Leg(const Vector3d& axis, const Vector3d& normal) {
    copy.size = {100, 90, 110};
    copy.spacing = 2;
    copy.origin = {-40, -150, 300};
    cut = {
        "knee_left", part_label("thigh_left"), part_label("shank_left"), {61, -58, 409}, normal.normalized()};
    for (std::int64_t k = 0; k < copy.size[2]; ++k)
      for (std::int64_t j = 0; j < copy.size[1]; ++j)
        for (std::int64_t i = 0; i < copy.size[0]; ++i) {
          const Vector3d index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
          const Vector3d away = copy.origin + copy.spacing * index - cut.point;
          const bool inside = axis.normalized().cross(away).norm() <= 40;
          copy.labels.push_back(!inside ? 0 : away.dot(cut.normal) > 0 ? 1 : 2);
        }
  }
};

TEST(CutLines, CrossTheLimbThatTheyCut) {
  for (const double tilt : {-0.5, 0.0, 0.3}) {  // of the limb in the coronal plane
    const Vector3d down(std::sin(tilt), 0, -std::cos(tilt));
    const Leg leg(down, down);
    const auto lines = cut_lines(leg.copy, names, {leg.cut});
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].joint, "knee_left");
    const Vector3d across(std::cos(tilt), 0, std::sin(tilt));
    // voxels of 2 mm and samples of 2 mm: an end is sharp to one of each
    EXPECT_LT((lines[0].from - (leg.cut.point - 40 * across)).norm(), 4) << lines[0].from.transpose();
    EXPECT_LT((lines[0].to - (leg.cut.point + 40 * across)).norm(), 4) << lines[0].to.transpose();
    EXPECT_NEAR((lines[0].from - leg.cut.point).dot(leg.cut.normal), 0, 1e-9);
    EXPECT_NEAR((lines[0].to - leg.cut.point).dot(leg.cut.normal), 0, 1e-9);
  }
}

TEST(CutLines, ShowPlanesTiltedInDepthOverTheirWidth) {
  const Leg leg({0, 0, -1}, {0, 0.6, -0.8});
  const auto lines = cut_lines(leg.copy, names, {leg.cut});
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(lines[0].from[0], leg.cut.point[0] - 40, 4);
  EXPECT_NEAR(lines[0].to[0], leg.cut.point[0] + 40, 4);
  EXPECT_NEAR(lines[0].from[2], leg.cut.point[2], 1e-9);
}

TEST(CutLines, EndAtTheirReach) {
  Leg leg({0, 0, -1}, {0, 0, -1});
  leg.cut.reach = 20;
  const auto lines = cut_lines(leg.copy, names, {leg.cut});
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(lines[0].from[0], leg.cut.point[0] - 20, 2);
  EXPECT_NEAR(lines[0].to[0], leg.cut.point[0] + 20, 2);
}

TEST(CutLines, ShowOnlyPlanesThatCutTheLabels) {
  Leg leg({0, 0, -1}, {0, 0, -1});
  Cut elsewhere = leg.cut;
  elsewhere.point[2] += 30;  // thigh on both sides
  Cut other = leg.cut;
  other.distal = part_label("shank_right");
  Cut flat = leg.cut;
  flat.normal = -Vector3d::UnitY();  // gives no line in the picture
  EXPECT_TRUE(cut_lines(leg.copy, names, {elsewhere, other, flat}).empty());
  leg.copy.labels.clear();
  EXPECT_TRUE(cut_lines(leg.copy, names, {leg.cut}).empty());
}

}  // namespace
}  // namespace borelli
