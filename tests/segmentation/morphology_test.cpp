#include "segmentation/grid/morphology.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numeric>
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

TEST(Morphology, DistanceIsToTheNearestSetVoxel) {
  const double step = 2.5;
  const Mask mask = random_mask({11, 9, 13}, step, 0.01, 3);
  const auto distance = distance_to(mask, 1000);
  each(mask.grid, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    // float's rounding of distances below 50 mm
    EXPECT_NEAR(distance.at(i, j, k), brute_distance(mask, i, j, k, step), 1e-5);
  });
}

TEST(Morphology, DistancesAgreeUpToTheirReach) {
  // limits below and above 127 voxels, whose squares need 16 and 32 bits; rows longer than a vector;
  // distances to the grid's outside
  const double step = 1.5;
  for (const double share : {0.0005, 0.9, 0.0}) {
    const Mask mask = random_mask({71, 9, 13}, step, share, 5);
    const auto brute = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      return brute_distance(mask, i, j, k, step);
    };
    const auto longest = distance_to(mask, 1000), longest_or_out = distance_to(mask, 1000, true);
    for (const double reach : {4.0, 30.0, 190.0, 200.0, 300.0}) {
      const auto distance = distance_to(mask, reach), or_out = distance_to(mask, reach, true);
      each(mask.grid, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        EXPECT_EQ(distance.at(i, j, k), std::min(longest.at(i, j, k), static_cast<float>(reach)));
        EXPECT_EQ(or_out.at(i, j, k), std::min(longest_or_out.at(i, j, k), static_cast<float>(reach)));
      });
    }
    each(mask.grid, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      const double out = step * static_cast<double>(1 + std::min({i, 70 - i, j, 8 - j, k, 12 - k}));
      EXPECT_NEAR(longest.at(i, j, k), std::min(1000.0, brute(i, j, k)), 1e-4);
      EXPECT_NEAR(longest_or_out.at(i, j, k), std::min(out, brute(i, j, k)), 1e-5);
    });
  }
}

TEST(Morphology, DistancesFrom256VoxelsGiveTheReach) {
  Mask mask = random_mask({300, 1, 1}, 0.5, 0, 1);
  mask.at(0, 0, 0) = 1;
  const auto distance = distance_to(mask, 1000);
  EXPECT_FLOAT_EQ(distance.at(255, 0, 0), 127.5);
  EXPECT_FLOAT_EQ(distance.at(256, 0, 0), 1000);
  EXPECT_FLOAT_EQ(distance.at(299, 0, 0), 1000);
}

TEST(Morphology, DistanceRespectsReachAndOutside) {
  Mask mask = random_mask({9, 9, 9}, 1, 0, 1);
  EXPECT_FLOAT_EQ(distance_to(mask, 7).at(4, 4, 4), 7);
  EXPECT_FLOAT_EQ(distance_to(mask, 100, true).at(4, 4, 4), 5);
  EXPECT_FLOAT_EQ(distance_to(mask, 100, true).at(0, 4, 4), 1);
}

TEST(Morphology, DilationThenErosionKeepsABall) {
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
  mask.at(9, 9, 9) = 1;  // touches the previous one only at a corner
  const Regions by_corners = connected_regions(mask, 26), by_faces = connected_regions(mask, 6);
  ASSERT_EQ(by_corners.list.size(), 2U);
  EXPECT_EQ(by_faces.list.size(), 3U);
  EXPECT_EQ(by_corners.list[0].voxels, 4);
  EXPECT_EQ(by_corners.list[0].low, (std::array<std::int64_t, 3>{1, 2, 2}));
  EXPECT_EQ(by_corners.list[0].high, (std::array<std::int64_t, 3>{4, 2, 2}));
  EXPECT_TRUE(by_corners.list[0].centre.isApprox(Eigen::Vector3d(2.5, 2, 2)));
  EXPECT_EQ(by_corners.number.at(9, 9, 9), 2);
}

// Each voxel takes the smallest index among itself and its neighbours until none changes.
std::vector<std::size_t> spread_places(const Mask& mask, int neighbours) {
  const Grid& g = mask.grid;
  std::vector<std::size_t> place(g.count());
  std::iota(place.begin(), place.end(), std::size_t{0});
  for (bool changed = true; changed;) {
    changed = false;
    each(g, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      if (!mask.at(i, j, k)) return;
      each({{3, 3, 3}}, [&](std::int64_t a, std::int64_t b, std::int64_t c) {
        if (neighbours == 6 && std::abs(a - 1) + std::abs(b - 1) + std::abs(c - 1) > 1) return;
        const std::int64_t x = i + a - 1, y = j + b - 1, z = k + c - 1;
        if (!g.holds(x, y, z) || !mask.at(x, y, z)) return;
        std::size_t& here = place[g.offset(i, j, k)];
        if (place[g.offset(x, y, z)] >= here) return;
        here = place[g.offset(x, y, z)];
        changed = true;
      });
    });
  }
  return place;
}

TEST(Morphology, RegionsMatchFloodFill) {
  for (const double share : {0.08, 0.3, 0.7, 1.0})
    for (const int neighbours : {6, 26}) {
      const Mask mask = random_mask({19, 7, 8}, 1, share, 11);
      const Regions regions = connected_regions(mask, neighbours);
      const auto place = spread_places(mask, neighbours);
      std::map<std::size_t, std::int32_t> number;  // region number by index
      std::vector<std::int64_t> voxels(regions.list.size() + 1, 0);
      for (std::size_t o = 0; o < mask.grid.count(); ++o) {
        const std::int32_t here = regions.number.voxels[o];
        ASSERT_EQ(here > 0, mask.voxels[o] != 0);
        if (here == 0) continue;
        ++voxels[static_cast<std::size_t>(here)];
        EXPECT_EQ(number.try_emplace(place[o], here).first->second, here);
      }
      EXPECT_EQ(number.size(), regions.list.size());
      for (std::size_t n = 0; n < regions.list.size(); ++n) {
        EXPECT_EQ(regions.list[n].voxels, voxels[n + 1]);
        if (n > 0) {
          EXPECT_LE(regions.list[n].voxels, regions.list[n - 1].voxels);
        }
      }
      for (const int threads : {1, 2, 3, 20}) {  // borders between slabs at different positions
        const Regions same = connected_regions(mask, neighbours, threads);
        EXPECT_TRUE(std::equal(same.number.voxels.get(), same.number.voxels.get() + mask.grid.count(),
                               regions.number.voxels.get()));
        ASSERT_EQ(same.list.size(), regions.list.size());
        for (std::size_t n = 0; n < same.list.size(); ++n) {
          EXPECT_EQ(same.list[n].low, regions.list[n].low);
          EXPECT_EQ(same.list[n].high, regions.list[n].high);
          EXPECT_EQ(same.list[n].centre, regions.list[n].centre);
        }
      }
      const Mask small = kept_regions(mask, neighbours, [](const Region& one, const Region& largest) {
        return 2 * one.voxels < largest.voxels;
      });
      for (std::size_t o = 0; o < mask.grid.count(); ++o)
        EXPECT_EQ(small.voxels[o], regions.number.voxels[o] > 0 &&
                                       2 * voxels[static_cast<std::size_t>(regions.number.voxels[o])] <
                                           regions.list[0].voxels);
    }
}

TEST(Morphology, ReachedVoxelsSpreadFromSeedsOrSliceSides) {
  for (const double share : {0.3, 0.6, 1.0}) {
    const Mask mask = random_mask({19, 7, 8}, 1, share, 12), seed = random_mask({19, 7, 8}, 1, 0.02, 13);
    const auto place = spread_places(mask, 6);
    std::vector<bool> seeded(mask.grid.count(), false);
    for (std::size_t o = 0; o < mask.grid.count(); ++o)
      if (mask.voxels[o] && seed.voxels[o]) seeded[place[o]] = true;
    const Mask got = reached(seed, mask);
    for (std::size_t o = 0; o < mask.grid.count(); ++o)
      EXPECT_EQ(got.voxels[o] != 0, mask.voxels[o] && seeded[place[o]]);

    const Mask from_sides = reached_from_sides(mask);
    for (std::int64_t k = 0; k < 8; ++k) {
      Mask slice = random_mask({19, 7, 1}, 1, 0, 1), sides = slice;
      each(slice.grid, [&](std::int64_t i, std::int64_t j, std::int64_t) {
        slice.at(i, j, 0) = mask.at(i, j, k);
        sides.at(i, j, 0) = i == 0 || j == 0 || i == 18 || j == 6;
      });
      const Mask open = reached(sides, slice);
      each(slice.grid, [&](std::int64_t i, std::int64_t j, std::int64_t) {
        EXPECT_EQ(from_sides.at(i, j, k), open.at(i, j, 0));
      });
    }
  }
}

}  // namespace
}  // namespace borelli
