// The navel among the dents of a trunk's front.
#include "segmentation/joints/trunk_front.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double navel_level = 200, fold_level = 145;  // mm above the grid's bottom

// An elliptic trunk with a navel (depth `pit`, mm) in the middle of its front, and a wide fold (depth `fold`,
// mm) below it on the left.
struct Belly {
  Anatomy anatomy;
  Trunk trunk;
  Limbs limbs;

  Belly(double pit, double fold) {
    constexpr double step = 3;
    Grid g;
    g.size = {121, 81, 101};
    g.axes = step * Eigen::Matrix3d::Identity();
    g.origin = Vector3d(-180, -130, 0);
    anatomy.scan.hu.grid = anatomy.body.grid = limbs.territory.owner.grid = g;
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const Vector3d p = g.point(i, j, k);
          const double aside = p[0] / 160, round = std::sqrt(std::max(0.0, 1 - aside * aside));
          // distances from pit and fold, in their own half widths
          const double from_pit = std::hypot(p[0], p[2] - navel_level) / 8,
                       from_fold =
                           std::hypot(std::max(0.0, std::abs(p[0] - 30) - 40) / 15, (p[2] - fold_level) / 18);
          const double front =
              -100 * round + pit * std::exp(-from_pit * from_pit) + fold * std::exp(-from_fold * from_fold);
          const double inside = round > 0 ? std::min(p[1] - front, 100 * round - p[1]) : -1e3;
          anatomy.scan.hu.voxels.push_back(
              static_cast<std::int16_t>(-1000 + 1040 * std::clamp(0.5 + inside / step, 0.0, 1.0)));
          anatomy.body.voxels.push_back(inside > 0);
        }
    limbs.territory.owner.voxels.assign(g.count(), 0);
    for (std::int64_t k = 0; k < g.size[2]; ++k) trunk.spine.push_back(Vector3d(0, 40, g.point(0, 0, k)[2]));
  }

  std::optional<Landmark> navel(double usual) const {
    return TrunkFront(anatomy, trunk, limbs, 0, 300).navel(100, 260, usual, 25);
  }
};

TEST(TrunkFront, PrefersNarrowNavelToDeeperFold) {
  const auto navel = Belly(9, 14).navel(navel_level - 20);
  ASSERT_TRUE(navel);
  EXPECT_LT(std::hypot(navel->point[0], navel->point[2] - navel_level), 3);
  EXPECT_NEAR(navel->point[1], -98, 4) << "nearly in the skin's plane";
  EXPECT_LT(navel->deviation, 6);
}

TEST(TrunkFront, ShallowNavelHasLargerDeviation) {
  const auto deep = Belly(9, 0).navel(navel_level - 20), shallow = Belly(5, 0).navel(navel_level - 20);
  ASSERT_TRUE(deep);
  ASSERT_TRUE(shallow);
  EXPECT_GT(shallow->deviation, 2 * deep->deviation);
}

TEST(TrunkFront, FindsNoNavelInAFoldAlone) { EXPECT_FALSE(Belly(0, 14).navel(navel_level)); }

}  // namespace
}  // namespace borelli
