#include "segmentation/geodesic.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli {
namespace {

Volume<float> even_cost(std::array<std::int64_t, 3> size, double step, float cost) {
  Volume<float> out;
  out.grid.size = size;
  out.grid.axes = step * Eigen::Matrix3d::Identity();
  out.voxels.assign(out.grid.count(), cost);
  return out;
}
Volume<std::uint8_t> no_seeds(const Grid& grid) { return {grid, std::vector<std::uint8_t>(grid.count(), 0)}; }

// length of a way that steps along faces, edges and corners (Borgefors 1986, with exact step lengths)
double octile(double a, double b, double c) {
  double d[3] = {std::abs(a), std::abs(b), std::abs(c)};
  std::sort(d, d + 3);
  return std::sqrt(3.0) * d[0] + std::sqrt(2.0) * (d[1] - d[0]) + (d[2] - d[1]);
}

TEST(Geodesic, EvenCostGivesTheLengthOfTheWay) {
  const auto cost = even_cost({15, 11, 9}, 2, 3);
  auto seeds = no_seeds(cost.grid);
  seeds.at(4, 5, 2) = 7;
  const auto found = geodesic(cost, seeds, true);
  for (std::int64_t k = 0; k < 9; ++k)
    for (std::int64_t j = 0; j < 11; ++j)
      for (std::int64_t i = 0; i < 15; ++i) {
        const double expected =
            3 * 2 *
            octile(static_cast<double>(i - 4), static_cast<double>(j - 5), static_cast<double>(k - 2));
        EXPECT_NEAR(found.length.at(i, j, k), expected, 1e-4 * (1 + expected));  // sums of floats
        EXPECT_EQ(found.owner.at(i, j, k), 7);
      }
  const auto way = way_to(found, static_cast<std::uint32_t>(cost.grid.offset(14, 5, 2)));
  EXPECT_EQ(way.size(), 11U);
  EXPECT_EQ(way.front(), cost.grid.offset(4, 5, 2));
}

TEST(Geodesic, WallsAreGoneRoundAndSeedsShareTheRest) {
  auto cost = even_cost({21, 21, 1}, 1, 1);
  for (std::int64_t j = 0; j < 20; ++j) cost.at(10, j, 0) = no_way;
  auto seeds = no_seeds(cost.grid);
  seeds.at(9, 0, 0) = 1;
  seeds.at(20, 20, 0) = 2;
  const auto found = geodesic(cost, seeds, false);
  EXPECT_EQ(found.owner.at(10, 3, 0), 0);  // the wall itself
  EXPECT_EQ(found.owner.at(11, 0, 0),
            2);  // two voxels from seed 1 across the wall, but nearer to seed 2 round it
  EXPECT_EQ(found.owner.at(9, 15, 0), 1);
  EXPECT_EQ(nearest_seeds(cost, seeds).voxels, found.owner.voxels);
}

TEST(Geodesic, LongWaysAreLeftWhereAsked) {
  const auto cost = even_cost({30, 3, 3}, 1, 1);
  auto seeds = no_seeds(cost.grid);
  seeds.at(0, 1, 1) = 1;
  const auto found = geodesic(cost, seeds, false, 10.5F);
  EXPECT_EQ(found.owner.at(10, 1, 1), 1);
  EXPECT_EQ(found.owner.at(11, 1, 1), 0);
  EXPECT_EQ(found.length.at(11, 1, 1), no_way);
}

}  // namespace
}  // namespace borelli
