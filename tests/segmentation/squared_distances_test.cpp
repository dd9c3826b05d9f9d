#include "segmentation/grid/squared_distances.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace borelli::test {
namespace {

// brute force over all voxels and those just outside
template <class Word>
Word nearest(const Volume<std::uint8_t>& mask, const DistanceOptions& options, Word cap, std::int64_t i,
             std::int64_t j, std::int64_t k) {
  const auto& size = mask.grid.size;
  std::int64_t best = cap;
  const std::int64_t edge = std::min({i + 1, j + 1, k + 1, size[0] - i, size[1] - j, size[2] - k});
  if (options.outside_is_near) best = std::min(best, edge * edge);
  for (std::int64_t z = 0; z < size[2]; ++z)
    for (std::int64_t y = 0; y < size[1]; ++y)
      for (std::int64_t x = 0; x < size[0]; ++x)
        if ((mask.at(x, y, z) == 0) == options.to_unset)
          best = std::min(best, (x - i) * (x - i) + (y - j) * (y - j) + (z - k) * (z - k));
  return static_cast<Word>(best);
}

template <class Word>
void expect_nearest(const std::array<std::int64_t, 3>& size, double share, Word cap) {
  Volume<std::uint8_t> mask;
  mask.grid.size = size;
  std::mt19937 random(7);
  std::bernoulli_distribution set(share);
  for (std::size_t o = 0; o < mask.grid.count(); ++o) mask.voxels.push_back(set(random) ? 1 : 0);
  for (const bool to_unset : {false, true})
    for (const bool outside : {false, true})
      for (const int bytes : {16, 32, 64}) {
        const DistanceOptions options{to_unset, outside, 2, bytes};
        const Volume<Word> found = squared_distances(mask, cap, options);
        for (std::int64_t k = 0; k < size[2]; ++k)
          for (std::int64_t j = 0; j < size[1]; ++j)
            for (std::int64_t i = 0; i < size[0]; ++i)
              ASSERT_EQ(found.at(i, j, k), nearest(mask, options, cap, i, j, k))
                  << bytes << " bytes, " << i << ' ' << j << ' ' << k;
      }
}

// lines that fill vectors of each width, and some that do not
TEST(SquaredDistances, AreExactForEveryVectorWidth) {
  for (const std::int64_t width : {5, 32, 45, 70})
    for (const double share : {0.004, 0.3, 0.996}) {
      expect_nearest<std::uint16_t>({width, 7, 9}, share, 400);
      expect_nearest<std::uint32_t>({width, 7, 9}, share, 70000);
    }
}

// one voxel set, in a corner: its three neighbours are nearer than the cap
TEST(SquaredDistances, AreCappedFarFromSetVoxels) {
  for (const int bytes : {16, 32, 64}) {
    Volume<std::uint8_t> mask;
    mask.grid.size = {40, 40, 40};
    mask.voxels.assign(mask.grid.count(), 0);
    mask.voxels[mask.grid.offset(39, 39, 39)] = 1;
    const auto found = squared_distances(mask, std::uint16_t{2}, {.vector_bytes = bytes});
    EXPECT_EQ(std::count(found.voxels.begin(), found.voxels.end(), 0), 1);
    EXPECT_EQ(std::count(found.voxels.begin(), found.voxels.end(), 1), 3);
    EXPECT_EQ(std::count(found.voxels.begin(), found.voxels.end(), 2), 40 * 40 * 40 - 4);
  }
}

}  // namespace
}  // namespace borelli::test
