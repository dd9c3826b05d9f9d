// Close-up pictures of balls and a rod at known positions: the picture agrees with the fit.
#include "pipeline/export/fit_pictures.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace borelli {
namespace {

using Eigen::Vector3d;

const Vector3d ball(31, -12, 44), rod(-35, 10, -20);
const Vector3d rod_axis = Vector3d(1, 0.25, -0.2).normalized();
constexpr double ball_radius = 21, rod_radius = 14;

// 700 on a ground of 40, on a grid turned and sheared from the patient's axes
GreyVolume scan() {
  GreyVolume volume;
  volume.quantity = Quantity::hu;
  Grid& g = volume.grid;
  g.size = {170, 170, 110};
  g.axes = Eigen::AngleAxisd(0.3, Vector3d(1, 2, -1).normalized()).toRotationMatrix() *
           Vector3d(1, 1, 1.5).asDiagonal();
  g.origin = -g.axes * Vector3d(85, 85, 55);
  volume.voxels.resize(g.count());
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.point({double(i), double(j), double(k)});
        const bool bone = (p - ball).norm() < ball_radius || (p - rod).cross(rod_axis).norm() < rod_radius;
        volume.at(i, j, k) = bone ? 700 : 40;
      }
  return volume;
}

// The bone in a picture: share of bytes above the middle between bone and background, and their mean position
// from the picture's centre, pixels.
struct Disc {
  double share = 0;
  Eigen::Vector2d off = Eigen::Vector2d::Zero();
};
Disc disc_in(const FitPlane& plane) {
  const double middle = 255 * (370 - FitPicture::low) / (FitPicture::high - FitPicture::low);
  Disc disc;
  for (int v = 0; v < FitPicture::pixels; ++v)
    for (int u = 0; u < FitPicture::pixels; ++u)
      if (plane.grey[static_cast<std::size_t>(v * FitPicture::pixels + u)] > middle) {
        ++disc.share;
        disc.off += Eigen::Vector2d(u, v) - Eigen::Vector2d::Constant(0.5 * (FitPicture::pixels - 1));
      }
  disc.off /= disc.share;
  disc.share /= FitPicture::pixels * FitPicture::pixels;
  return disc;
}

TEST(FitPictures, BoneLiesWithinItsCircle) {
  Landmarks marks;
  marks["hip_left"] = {ball, 1.5, ball_radius, "bone: sphere on the femoral head"};
  marks["knee_right"] = {rod, 2, rod_radius, "bone: cylinder on the femoral condyles"};
  marks["knee_lateral_right"] = {rod - 30 * rod_axis, 4, 0, ""};
  marks["knee_medial_right"] = {rod + 30 * rod_axis, 4, 0, ""};
  marks["neck"] = {Vector3d(0, 0, 60), 5, 0, ""};
  const auto pictures = fit_pictures(scan(), marks);
  ASSERT_EQ(pictures.size(), 2U);
  EXPECT_EQ(pictures[0].joint, "hip_left");
  ASSERT_EQ(pictures[0].planes.size(), 2U);
  ASSERT_EQ(pictures[1].planes.size(), 2U);
  for (const FitPicture& picture : pictures)
    for (const FitPlane& plane : picture.planes) {
      SCOPED_TRACE(picture.joint + " " + plane.name);
      const Disc disc = disc_in(plane);
      const double exact = std::numbers::pi * std::pow(picture.fit.radius / picture.side, 2);
      EXPECT_NEAR(disc.share / exact, 1, 0.03);
      EXPECT_LT(disc.off.norm() * picture.side / FitPicture::pixels, 0.5);
    }
  EXPECT_NEAR(std::abs(pictures[1].planes[0].across.cross(pictures[1].planes[0].down).dot(rod_axis)), 1,
              1e-9);
}

// A wrong centre shows in the picture with its error and direction: the patient's left is on the right, up is
// up.
TEST(FitPictures, ShowAWrongCentre) {
  Landmarks marks;
  marks["hip_left"] = {ball + Vector3d(-5, 0, -4), 1.5, ball_radius, ""};
  const auto pictures = fit_pictures(scan(), marks);
  ASSERT_EQ(pictures.size(), 1U);
  const Eigen::Vector2d off = disc_in(pictures[0].planes[0]).off * pictures[0].side / FitPicture::pixels;
  EXPECT_NEAR(off[0], 5, 0.5);
  EXPECT_NEAR(off[1], -4, 0.5);
}

TEST(FitPictures, AreNotDrawnForMr) {
  Landmarks marks;
  marks["hip_left"] = {ball, 1.5, ball_radius, ""};
  GreyVolume volume = scan();
  volume.quantity = Quantity::mr;
  EXPECT_TRUE(fit_pictures(volume, marks).empty());
}

}  // namespace
}  // namespace borelli
