#include "segmentation/morphology.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace borelli {
namespace {

Mask random_mask(std::array<std::int64_t, 3> size, double step, double share, unsigned seed) {
  Mask mask;
  mask.grid.size = size;
  mask.grid.axes = step * Eigen::Matrix3d::Identity();
  std::mt19937 random(seed);
  std::bernoulli_distribution set(share);
  for (std::size_t n = 0; n < mask.grid.count(); ++n) mask.voxels.push_back(set(random));
  return mask;
}

template <class Visit>
void each(const Grid& g, const Visit& visit) {
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) visit(i, j, k);
}

double brute_distance(const Mask& mask, std::int64_t i, std::int64_t j, std::int64_t k, double step) {
  double best = std::numeric_limits<double>::infinity();
  each(mask.grid, [&](std::int64_t a, std::int64_t b, std::int64_t c) {
    if (mask.at(a, b, c))
      best = std::min(best, step * std::hypot(static_cast<double>(a - i), static_cast<double>(b - j),
                                              static_cast<double>(c - k)));
  });
  return best;
}

TEST(Morphology, DistanceIsTheNearestSetVoxels) {
  const double step = 2.5;
  const Mask mask = random_mask({11, 9, 13}, step, 0.01, 3);
  const auto distance = distance_to(mask, 1000);
  each(mask.grid, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    // float's rounding of distances below 50 mm
    EXPECT_NEAR(distance.at(i, j, k), brute_distance(mask, i, j, k, step), 1e-5);
  });
}

TEST(Morphology, DistanceIsHeldToItsReachAndMayCountTheOutside) {
  Mask mask = random_mask({9, 9, 9}, 1, 0, 1);
  EXPECT_FLOAT_EQ(distance_to(mask, 7).at(4, 4, 4), 7);
  EXPECT_FLOAT_EQ(distance_to(mask, 100, true).at(4, 4, 4), 5);
  EXPECT_FLOAT_EQ(distance_to(mask, 100, true).at(0, 4, 4), 1);
}

TEST(Morphology, DilationByABallThenErosionKeepsABall) {
  Mask point = random_mask({21, 21, 21}, 1, 0, 1);
  point.at(10, 10, 10) = 1;
  const Mask ball = dilated(point, 6);
  std::int64_t count = 0, expected = 0;
  each(ball.grid, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    count += ball.at(i, j, k);
    expected += (i - 10) * (i - 10) + (j - 10) * (j - 10) + (k - 10) * (k - 10) <= 36;
  });
  EXPECT_EQ(count, expected);
  EXPECT_EQ(eroded(ball, 6).at(10, 10, 10), 1);
  EXPECT_EQ(eroded(ball, 6.5).at(10, 10, 10), 0);
}

TEST(Morphology, RegionsAreLargestFirstAndKnowTheirBox) {
  Mask mask = random_mask({10, 10, 10}, 1, 0, 1);
  for (std::int64_t i = 1; i < 5; ++i) mask.at(i, 2, 2) = 1;
  mask.at(8, 8, 8) = 1;
  mask.at(9, 9, 9) = 1;  // touches the one before by a corner only
  const Regions by_corners = connected_regions(mask, 26), by_faces = connected_regions(mask, 6);
  ASSERT_EQ(by_corners.list.size(), 2U);
  EXPECT_EQ(by_faces.list.size(), 3U);
  EXPECT_EQ(by_corners.list[0].voxels, 4);
  EXPECT_EQ(by_corners.list[0].low, (std::array<std::int64_t, 3>{1, 2, 2}));
  EXPECT_EQ(by_corners.list[0].high, (std::array<std::int64_t, 3>{4, 2, 2}));
  EXPECT_TRUE(by_corners.list[0].centre.isApprox(Eigen::Vector3d(2.5, 2, 2)));
  EXPECT_EQ(by_corners.number.at(9, 9, 9), 2);
}

}  // namespace
}  // namespace borelli
