// The spine's course between the iliac wings.
#include "segmentation/joints/trunk.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

// A column leans to the left above a slender sacrum. Thicker iliac wings lie beside the sacrum and diverge upwards.
TEST(Trunk, SpineStaysBetweenTheIliacWings) {
  constexpr double step = 3, leaning = 0.3, wings_end = 110;
  Anatomy a;
  Grid g;
  g.size = {101, 61, 101};
  g.axes = step * Eigen::Matrix3d::Identity();
  g.origin = Vector3d(-150, -90, 0);
  a.scan.hu.grid = g;
  const auto column = [&](double z) { return leaning * std::max(0.0, z - wings_end); };
  const auto wing = [](double z) { return 50 + 0.5 * (z - 30); };
  Mask outside{g, {}};
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.point(i, j, k);
        const bool in_column = std::hypot(p[0] - column(p[2]), p[1]) < (p[2] < wings_end ? 10 : 18),
                   in_wing = p[2] < wings_end && std::hypot(std::abs(p[0]) - wing(p[2]), p[1]) < 20;
        outside.voxels.push_back(!in_column && !in_wing);
      }
  a.within_bone = distance_to(outside, 60);
  Trunk trunk;
  find_spine(a, 0, 30, 290, 15, 0.3, trunk);
  for (const double z : {40.0, 70.0, 100.0, 150.0, 200.0, 250.0})
    EXPECT_NEAR(trunk.spine_at(z)[0], column(z), 8) << "at level " << z;
}

}  // namespace
}  // namespace borelli
