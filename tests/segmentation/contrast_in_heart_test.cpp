// Spine and sternum of a chest with contrast in the heart.
#include <gtest/gtest.h>

#include <cmath>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Chest {
  Phantom body;
  Segmentation found;

  Landmark mark(const char* name) const {
    const auto it = found.landmarks.find(name);
    EXPECT_NE(it, found.landmarks.end()) << name;
    return it == found.landmarks.end() ? Landmark{} : it->second;
  }
  Vector3d off(const char* name) const { return mark(name).point - body.landmarks.at(name).point; }
};

// A phantom with a ball of contrast between spine and sternum. `soft`: the sternum is no denser than flesh.
Chest with_contrast(bool soft) {
  const auto body = build_phantom({});
  EXPECT_TRUE(body);
  GridOptions options;
  options.spacing.setConstant(3);
  options.crop_low[2] = body->landmarks.at("mid_hip").point[2] - 150;
  Scan scan = voxelise(*body, phantom_grid(*body, options), {.partial_volume = true, .noise_hu = 10});
  const Vector3d tip = body->landmarks.at("xiphion").point, top = body->landmarks.at("suprasternale").point;
  const double column = body->landmarks.at("spine_upper").point[1];
  const Vector3d heart(tip[0], 0.5 * (tip[1] + column), tip[2] + 35);
  constexpr double radius = 42;  // mm
  constexpr std::int16_t flesh = 50, contrast = 400;
  const Grid& g = scan.grey.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.point(i, j, k);
        std::int16_t& hu = scan.grey.voxels[g.offset(i, j, k)];
        const bool in_sternum =
            std::abs(p[0] - tip[0]) < 32 && p[1] < column - 60 && p[2] > tip[2] - 15 && p[2] < top[2] + 15;
        if (soft && in_sternum && hu > flesh) hu = flesh;
        if ((p - heart).norm() < radius) hu = contrast;
      }
  auto found = segment(scan.grey);
  EXPECT_TRUE(found);
  return {*body, found ? *found : Segmentation{}};
}

TEST(ContrastInTheHeart, IsNoSternum) {
  const Chest chest = with_contrast(true);
  const Landmark xiphion = chest.mark("xiphion");
  EXPECT_FALSE(xiphion.source.starts_with("bone")) << xiphion.source;
  EXPECT_LT(std::abs(chest.off("xiphion")[2]), 2 * xiphion.deviation);
  EXPECT_LT(chest.off("spine_upper").head<2>().norm(), 10);
}

// Half a vertebral body and two voxels are the tolerances.
TEST(ContrastInTheHeart, LeavesSternumAndSpineInTheirPlaces) {
  const Chest chest = with_contrast(false);
  EXPECT_TRUE(chest.mark("xiphion").source.starts_with("bone")) << chest.mark("xiphion").source;
  EXPECT_LT(std::abs(chest.off("xiphion")[2]), 6);
  EXPECT_LT(chest.off("spine_upper").head<2>().norm(), 10);
}

}  // namespace
}  // namespace borelli
