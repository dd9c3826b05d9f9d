// A skin's bones and points in poses: a limb twisted and bent, compared with a rigidly turned one.
#include "pipeline/export/skin_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/pipeline/export/capsule_labels.hpp"

namespace borelli::test::skin_pose_test {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

Skin limb_skin(const std::vector<SkinJoint>& joints, int helpers) {
  auto skin =
      skin_of(labels_of(limb(), 3), joints, {}, {.tolerance = 0.0005, .helpers = helpers, .threads = 1});
  EXPECT_TRUE(skin) << skin.error().message();
  return *skin;
}

std::vector<Vector3d> at_rest(const Skin& skin) {
  std::vector<Vector3d> points;
  for (const auto& p : skin.mesh.points) points.push_back(p.cast<double>());
  return points;
}

double volume(const Skin& skin, const std::vector<Vector3d>& points) {
  double six = 0;
  for (const auto& t : skin.mesh.triangles) six += points[t[0]].dot(points[t[1]].cross(points[t[2]]));
  return six / 6;
}

/// Number of triangles turned inside out: a point 0.1 mm below the triangle, moved with its corners' mean
/// weights, ends above it.
int flipped(const Skin& skin, const std::vector<Vector3d>& points, const ScanPoses& X_WS) {
  auto moved = bone_poses(skin, X_WS);
  const auto rest = rest_poses(skin);
  for (std::size_t b = 0; b < moved.size(); ++b) moved[b] = moved[b] * rest[b].inverse();
  const auto before = at_rest(skin);
  int count = 0;
  for (const auto& t : skin.mesh.triangles) {
    const Vector3d normal = (before[t[1]] - before[t[0]]).cross(before[t[2]] - before[t[0]]).normalized();
    const Vector3d middle = (before[t[0]] + before[t[1]] + before[t[2]]) / 3;
    const auto mean = [&](const Vector3d& p) {
      Vector3d sum = Vector3d::Zero();
      for (const auto corner : t)
        for (std::size_t c = 0; c < 4; ++c)
          sum += double(skin.weights[corner][c]) / 3 * (moved[skin.bones_of[corner][c]] * p);
      return sum;
    };
    const Vector3d up = mean(middle) - mean(middle - 1e-4 * normal);
    count += up.dot((points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]])) <= 0;
  }
  return count;
}

TEST(SwingTwist, RebuildsTheRotationWithASwingAcrossTheAxis) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 200; ++n) {
    const Vector3d axis = Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Eigen::Matrix3d R =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized()
            .toRotationMatrix();
    const SwingTwist parts = swing_twist(R, axis);
    const Eigen::Matrix3d swing = Eigen::AngleAxisd(parts.swing, parts.swing_axis).toRotationMatrix(),
                          twist = Eigen::AngleAxisd(parts.twist, axis).toRotationMatrix();
    EXPECT_LT((swing * twist - R).norm(), 1e-12);
    EXPECT_NEAR(parts.swing_axis.dot(axis), 0, 1e-12);
    EXPECT_NEAR(parts.swing_axis.norm(), 1, 1e-12);
    // the swing moves the axis as R does, by the shortest rotation
    EXPECT_LT((swing * axis - R * axis).norm(), 1e-12);
    EXPECT_NEAR(parts.swing, std::acos(std::clamp(axis.dot(R * axis), -1.0, 1.0)), 1e-7);
  }
  EXPECT_NEAR(swing_twist(turn_deg(-120, {0, 0, 1}), {0, 0, 1}).twist, -2 * pi / 3, 1e-14);
  EXPECT_NEAR(swing_twist(turn_deg(70, {0, 1, 0}), {0, 0, 1}).twist, 0, 1e-14);
  EXPECT_EQ(swing_twist(turn_deg(180, {0, 1, 0}), {0, 0, 1}).twist, 0);
}

TEST(BonePoses, MoveAPartWithoutAPoseWithItsParent) {
  const Skin skin = limb_skin(limb_joints(true), 1);
  const Pose X_W{turn_deg(40, {1, 2, 3}), {0.5, 0, 0.2}};
  const auto points = deformed(skin, {{"upper", X_W}});
  const auto rest = at_rest(skin);
  double worst = 0;
  for (std::size_t n = 0; n < rest.size(); ++n) worst = std::max(worst, (points[n] - X_W * rest[n]).norm());
  EXPECT_LT(worst, 1e-6);  // float weights sum to 1 within 1e-7
}

TEST(Deformed, GivesTheRestMeshInTheScansPose) {
  const ScanPoses X_WS{{"upper", {turn_deg(10, {1, 0, 0}), {0.1, 0, 0.8}}},
                       {"middle", {turn_deg(70, {0, 1, 1}), {0, 0, 0.6}}},
                       {"lower", {turn_deg(-30, {0, 1, 0}), {0, 0.1, 0.3}}}};
  const auto skin = skin_of(labels_of(limb(), 4), limb_joints(true), X_WS);
  ASSERT_TRUE(skin);
  for (const auto& points : {deformed(*skin, X_WS), deformed(*skin, {})}) {
    double worst = 0;
    for (std::size_t n = 0; n < points.size(); ++n)
      worst = std::max(worst, (points[n] - skin->mesh.points[n].cast<double>()).norm());
    EXPECT_LT(worst, 1e-6);
  }
}

// Blending two poses theta / n apart leaves cos(theta / 2n) of the radius halfway. n: intervals between
// bones. The twist of the upper joint runs along the segment below it, that of the lower joint along the
// segment above it, that of a hinge within its zone.
TEST(Deformed, ATwistLeavesTheCosineOfHalfItsShare) {
  const double theta = pi / 2;
  struct Case {
    bool upper_joint_twists, lower_joint_twists;
    const char* turned;
    std::size_t part;
    TwistAlong along;
  };
  for (const Case& c :
       {Case{true, false, "middle", 1, TwistAlong::part}, Case{false, false, "middle", 1, TwistAlong::zone},
        Case{false, true, "lower", 2, TwistAlong::parent}})
    for (const int helpers : {0, 1, 3}) {
      const auto joints = limb_joints(c.upper_joint_twists, c.lower_joint_twists);
      const Skin skin = limb_skin(joints, helpers);
      ASSERT_EQ(skin.parts[c.part].twist, c.along);
      const auto X_WS = turned(joints, {}, {{c.turned, turn_deg(90, {0, 0, 1})}});
      const auto points = deformed(skin, X_WS);
      double least = 1, most = 0;
      for (std::size_t n = 0; n < points.size(); ++n) {
        const Vector3d before = skin.mesh.points[n].cast<double>();
        if (before.z() < 0.03 || before.z() > 0.87) continue;  // the ends are discs
        const double left = points[n].head<2>().norm() / before.head<2>().norm();
        least = std::min(least, left);
        most = std::max(most, left);
      }
      const double theory = std::cos(theta / (2 * (helpers + 1)));
      // below: weights are interpolated between voxels 4 mm apart; above: no point is exactly halfway
      EXPECT_GT(least, theory - 0.002) << c.turned << helpers;
      EXPECT_LT(least, theory + 0.006) << c.turned << helpers;
      EXPECT_LT(most, 1 + 1e-6);
      if (helpers == 3) {
        EXPECT_EQ(flipped(skin, points, X_WS), 0) << c.turned;
      }
    }
}

// The zones reach 2 r into the segment of 300 mm, which leaves 140 mm. There the angle grows steadily;
// halfway between bones 22.5 degrees apart its slope is 1.3 % larger, tan(a / 2) / (a / 2).
TEST(Deformed, ATwistGrowsSteadilyAlongTheSegment) {
  const Skin skin = limb_skin(limb_joints(true), 3);
  const auto points = deformed(skin, turned(limb_joints(true), {}, {{"middle", turn_deg(90, {0, 0, 1})}}));
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Eigen::Vector2d products = Eigen::Vector2d::Zero();
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Vector3d before = skin.mesh.points[n].cast<double>();
    if (before.z() < 0.03 || before.z() > 0.87) continue;
    const double angle = std::atan2(before.x() * points[n].y() - before.y() * points[n].x(),
                                    before.head<2>().dot(points[n].head<2>()));
    if (before.z() > 0.53) {
      EXPECT_NEAR(angle, 0, 1e-5);
    }
    if (before.z() < 0.37) {
      EXPECT_NEAR(angle, pi / 2, 1e-5);
    }
    if (std::abs(before.z() - 0.45) > 0.04) continue;
    const Eigen::Vector2d row(1, before.z() - 0.45);
    squares += row * row.transpose();
    products += row * angle;
  }
  const Eigen::Vector2d line = squares.inverse() * products;
  for (const std::size_t joint : {1u, 2u}) EXPECT_NEAR(skin.parts[joint].half_thickness, 0.04, 0.003);
  const double left = 0.3 - 2 * skin.parts[1].half_thickness - 2 * skin.parts[2].half_thickness;
  EXPECT_NEAR(line[0], pi / 4, 0.0015 * 14);           // half a voxel
  EXPECT_NEAR(line[1] / (-(pi / 2) / left), 1, 0.03);  // two zones' ends, one voxel in total
}

/// Area of the limb's cross-section at height z at rest, whose points are now turned by R about c: the area
/// of the polygon of the points near that height, ordered by azimuth, in axes turned by R.
double section_area(const Skin& skin, const std::vector<Vector3d>& points, double z, const Eigen::Matrix3d& R,
                    const Vector3d& c) {
  std::map<double, Eigen::Vector2d> ring;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const auto& before = skin.mesh.points[n];
    if (std::abs(before.z() - z) > 0.004) continue;
    ring[std::atan2(before.y(), before.x())] = (R.transpose() * (points[n] - c)).head<2>();
  }
  double twice = 0;
  for (auto at = ring.begin(); at != ring.end(); ++at) {
    const auto next = std::next(at) == ring.end() ? ring.begin() : std::next(at);
    twice += at->second.x() * next->second.y() - at->second.y() * next->second.x();
  }
  return twice / 2;
}

TEST(Deformed, ABendOf150DegreesKeepsSectionAndVolume) {
  const Skin skin = limb_skin(limb_joints(false), 3);
  const Vector3d c(0, 0, 0.6);
  const auto rest = at_rest(skin);
  for (const double angle : {30.0, 90.0, 150.0}) {
    const auto X_WS = turned(limb_joints(false), {}, {{"middle", turn_deg(angle, {1, 0, 0})}});
    const auto points = deformed(skin, X_WS);
    const double section = section_area(skin, points, 0.6, turn_deg(angle / 2, {1, 0, 0}), c) /
                           section_area(skin, rest, 0.6, Eigen::Matrix3d::Identity(), c);
    EXPECT_GT(section, 0.9) << angle;
    EXPECT_LT(section, 1.05) << angle;
    EXPECT_NEAR(volume(skin, points) / volume(skin, rest), 1, 0.03) << angle;
    EXPECT_EQ(flipped(skin, points, X_WS), 0) << angle;
  }
}

/// A trunk on two thighs and as thick as they are, so that two cuts meet at the midline.
std::vector<LabelCapsule> hips() {
  return {{"trunk", {62, 0, 1000}, {62, 0, 600}, 58, false},
          {"trunk", {0, 0, 1000}, {0, 0, 600}, 58, false},
          {"trunk", {-62, 0, 1000}, {-62, 0, 600}, 58, false},
          {"left", {62, 0, 600}, {62, 0, 150}, 58, false},
          {"right", {-62, 0, 600}, {-62, 0, 150}, 58, false}};
}

// Each thigh's zone crosses the other's cut. Zones that end there flip 41 triangles at 120 degrees.
TEST(Deformed, AFlexedHipFoldsNeitherGroinNorTrunk) {
  const std::vector<SkinJoint> joints{{"trunk", "", {}, true},
                                      {"left", "trunk", Vector3d(0.062, 0, 0.6), true},
                                      {"right", "trunk", Vector3d(-0.062, 0, 0.6), true}};
  const auto skin = skin_of(labels_of(hips(), 3), joints, {}, {.tolerance = 0.0005, .threads = 1});
  ASSERT_TRUE(skin) << skin.error().message();
  for (const double angle : {-30.0, 60.0, 90.0, 120.0}) {
    const auto X_WS = turned(joints, {}, {{"left", turn_deg(-angle, {1, 0, 0})}});
    const auto points = deformed(*skin, X_WS);
    EXPECT_LE(flipped(*skin, points, X_WS), angle < 100 ? 0 : 2) << angle;  // where both cuts meet in a voxel
    EXPECT_NEAR(volume(*skin, points) / volume(*skin, at_rest(*skin)), 1, 0.03) << angle;
  }
}

// Shows that the test above measures the effect of helper bones.
TEST(Deformed, WithoutHelpersABendNarrowsTheMiddle) {
  const Skin skin = limb_skin(limb_joints(false), 0);
  const Vector3d c(0, 0, 0.6);
  const auto points = deformed(skin, turned(limb_joints(false), {}, {{"middle", turn_deg(150, {1, 0, 0})}}));
  const double section = section_area(skin, points, 0.6, turn_deg(75, {1, 0, 0}), c) /
                         section_area(skin, at_rest(skin), 0.6, Eigen::Matrix3d::Identity(), c);
  EXPECT_NEAR(section, std::cos(75 * pi / 180), 0.02);  // one of the two half axes shrinks
}

}  // namespace
}  // namespace borelli::test::skin_pose_test
