// The hip of a body that lacks a leg, where other round bones form a pair.
#include "segmentation/joints/lone_heads.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace borelli {
namespace {

using Eigen::Vector3d;

const Vector3d head(86, 0, 150);  // the left femur's, mm
constexpr double head_radius = 24;

bool in_ball(const Vector3d& p, const Vector3d& centre, double radius) {
  return (p - centre).norm() < radius;
}
bool in_bar(const Vector3d& p, const Vector3d& from, const Vector3d& to, double radius) {
  const Vector3d along = to - from;
  const double t = std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - from - t * along).norm() < radius;
}

// Hips of a body with a slender sacrum. Bone as round as a femoral head lies at each sacroiliac joint, with
// an ilium that leads on like a femur.
GreyVolume pelvis(bool right_leg) {
  GreyVolume volume;
  volume.grid.size = {131, 71, 141};
  volume.grid.axes = 3 * Eigen::Matrix3d::Identity();
  volume.grid.origin = Vector3d(-195, -105, 0);
  for (std::int64_t k = 0; k < volume.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < volume.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < volume.grid.size[0]; ++i) {
        const Vector3d p = volume.grid.point(i, j, k);
        Vector3d q = p;  // the same point of the left side
        q[0] = std::abs(q[0]);
        const bool leg = p[0] > 0 || right_leg;
        const bool in_trunk =
            std::hypot(q[0] / 160, p[1] / 95) < 1 && p[2] > 90 && (leg || q[0] < 75 || p[2] > 210);
        const bool in_thigh = leg && std::hypot(q[0] - 95, p[1]) < 75 && p[2] < 200;
        const bool femur = in_ball(q, head, head_radius) || in_bar(q, head, {135, 5, 135}, 12) ||
                           in_ball(q, {135, 5, 130}, 17) || in_bar(q, {130, 0, 120}, {110, 0, 0}, 14);
        const bool ilium = in_ball(q, {66, 40, 245}, 20) || in_bar(q, {66, 40, 245}, {90, 10, 190}, 9) ||
                           in_bar(q, {60, 35, 245}, {75, 15, 110}, 8);
        const bool column = std::hypot(p[0], p[1] - 50) < (p[2] > 290 ? 20 : 12) && p[2] > 170;
        const bool bone = column || ilium || (leg && femur);
        volume.voxels.push_back(bone ? 700 : in_trunk || in_thigh ? 40 : -1000);
      }
  return volume;
}

Trunk trunk_of(const GreyVolume& volume) {
  return find_trunk(anatomy_of(volume, work_grid(volume, 3, 0), 0));
}

TEST(LoneHeads, OneHipReplacesAFalsePair) {
  const Trunk trunk = trunk_of(pelvis(false));
  ASSERT_TRUE(trunk.hip[left_side] && trunk.hip[right_side]);
  EXPECT_TRUE(trunk.no_leg[right_side]);
  EXPECT_FALSE(trunk.no_leg[left_side]);
  EXPECT_LT((trunk.hip[left_side]->centre - head).norm(), 3) << trunk.hip[left_side]->centre.transpose();
  EXPECT_NEAR(trunk.hip[right_side]->centre[0], -head[0], 12);
}

TEST(LoneHeads, TwoLegsKeepTheirPair) {
  const Trunk trunk = trunk_of(pelvis(true));
  ASSERT_TRUE(trunk.hip[left_side] && trunk.hip[right_side]);
  EXPECT_FALSE(trunk.no_leg[left_side] || trunk.no_leg[right_side]);
  for (const int side : {left_side, right_side}) {
    const Vector3d true_head(side_sign(side) * head[0], head[1], head[2]);
    EXPECT_LT((trunk.hip[static_cast<std::size_t>(side)]->centre - true_head).norm(), 3);
  }
}

}  // namespace
}  // namespace borelli
