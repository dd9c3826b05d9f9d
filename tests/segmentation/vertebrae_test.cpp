// The first rib beside the spine.
#include "segmentation/joints/vertebrae.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double first = 180, rib_high = 12;  // mm: upper edge of the first rib; height of a rib

// Ribs on both sides of a straight column, `apart` mm from one to the next. `bone_on_the_left`: bone, like a
// vein with contrast, also lies above the first rib, on the left alone.
struct Ribs {
  Anatomy anatomy;
  Trunk trunk;

  Ribs(double apart, bool bone_on_the_left) {
    constexpr double step = 3;
    Grid g;
    g.size = {61, 41, 101};
    g.axes = step * Eigen::Matrix3d::Identity();
    g.origin = Vector3d(-90, -60, 0);
    anatomy.scan.hu.grid = anatomy.bone.grid = g;
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const Vector3d p = g.point(i, j, k);
          const bool beside = std::abs(p[0]) > 20 && std::abs(p[0]) < 80 && p[1] > 0 && p[1] < 12;
          const double below = first - p[2];
          const bool rib = below >= 0 && std::fmod(below, apart) < rib_high;
          const bool vein = bone_on_the_left && p[0] > 0 && below < 0 && below > -60;
          anatomy.bone.voxels.push_back(beside && (rib || vein));
        }
    for (std::int64_t k = 0; k < g.size[2]; ++k) trunk.spine.push_back(g.point(30, 20, k));
  }
  double first_rib_off() const {
    const auto found = first_rib(anatomy, trunk, first + 25);
    EXPECT_TRUE(found);
    return found ? *found - first : 1e9;
  }
};

TEST(FirstRib, IsTheHighestPairOfRibs) {
  EXPECT_LT(std::abs(Ribs(28, false).first_rib_off()), 4);
  // a long chest
  EXPECT_LT(std::abs(Ribs(40, false).first_rib_off()), 4);
}

// Bone of the other side counts up to 8 mm away, plus a voxel of 3 mm.
TEST(FirstRib, IsNoBoneOnOneSide) { EXPECT_LT(std::abs(Ribs(28, true).first_rib_off()), 12); }

}  // namespace
}  // namespace borelli
