#include "segmentation/joints/spheres.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Scene {
  Volume<std::int16_t> hu;
  Mask bone;
};

// a ball of bone in soft tissue with a blurred edge, as from a scanner, and a shaft below it
Scene ball_on_shaft(const Vector3d& centre, double radius, double step) {
  Scene scene;
  auto& g = scene.hu.grid;
  g.size = {50, 50, 60};
  g.axes = step * Eigen::Matrix3d::Identity();
  g.origin = Vector3d(-70, -60, -100);
  scene.bone.grid = g;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vector3d d = g.point(i, j, k) - centre;
        const double to_ball = d.norm() - radius;
        const double to_shaft = d[2] < 0 ? std::hypot(d[0], d[1]) - 0.5 * radius : 1e9;
        const double t = std::clamp(0.5 - std::min(to_ball, to_shaft) / step, 0.0, 1.0);
        scene.hu.voxels.push_back(static_cast<std::int16_t>(40 + 700 * t));
        scene.bone.voxels.push_back(t > 0.3);
      }
  return scene;
}

GreyVolume scan_of(const Scene& scene) {
  GreyVolume volume;
  volume.grid = scene.hu.grid;
  volume.voxels = scene.hu.voxels;
  return volume;
}

TEST(Spheres, SphereThroughItsPointsIsExact) {
  const Vector3d c(3, -7, 110);
  std::vector<Vector3d> points;
  for (const Vector3d& u : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(-0.6, 0.8, 0),
                            Vector3d(0, -0.6, -0.8)})
    points.push_back(c + 24.5 * u);
  const auto ball = sphere_through(points);
  ASSERT_TRUE(ball);
  EXPECT_LT((ball->centre - c).norm(), 1e-9);
  EXPECT_NEAR(ball->radius, 24.5, 1e-9);
  points.resize(3);
  EXPECT_FALSE(sphere_through(points));
  points.push_back((points[0] + points[1] + points[2]) / 3);
  EXPECT_FALSE(sphere_through(points)) << "coplanar points have no sphere";
}

TEST(Spheres, FindsAndMeasuresAHeadOnAShaft) {
  const Vector3d centre(1.3, 2.1, -6.4);
  const Scene scene = ball_on_shaft(centre, 24, 3);
  const auto votes = vote_balls(scene.hu, scene.bone, 17, 29, 15);
  ASSERT_FALSE(votes.empty());
  EXPECT_LT((votes[0].centre - centre).norm(), 6) << "two voxels: the votes are counted per voxel";
  const auto balls = fit_balls(scan_of(scene), votes[0].centre, 15, 31);
  ASSERT_FALSE(balls.empty());
  // a sixth of a voxel: edges are interpolated in voxels of 3 mm, and the shaft shifts nearby ones
  EXPECT_LT((balls[0].centre - centre).norm(), 0.5);
  EXPECT_NEAR(balls[0].radius, 24, 0.5);
}

TEST(Spheres, FitsNothingWithoutABall) {
  Scene scene = ball_on_shaft(Vector3d(0, 0, 0), 24, 3);
  for (auto& v : scene.hu.voxels) v = 40;
  EXPECT_TRUE(fit_balls(scan_of(scene), Vector3d(0, 0, 0), 15, 31).empty());
}

}  // namespace
}  // namespace borelli
