// The histogram of grey values against a plain count per bin, and the choice of bins.
#include "pipeline/export/histogram.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/pipeline/capsule_body.hpp"

namespace borelli {
namespace {

std::uint64_t sum(const std::vector<std::uint64_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

TEST(Histogram, EqualsAPlainCountOfEveryBin) {
  CapsuleScan scan = capsule_scan(capsule_grid(12));
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 35);
  for (auto& voxel : scan.grey.voxels) voxel = static_cast<std::int16_t>(std::lround(voxel + noise(random)));
  const std::size_t n = scan.grey.voxels.size();
  for (const int threads : {1, 3}) {
    const Histogram made = histogram(scan.grey, &scan.labels, 320, threads);
    EXPECT_EQ(made.width, 10);  // 2000 values or so in at most 320 bins
    EXPECT_EQ(made.low % made.width, 0);
    ASSERT_EQ(made.all.size(), made.body.size());
    std::size_t held = 0;
    for (std::size_t bin = 0; bin < made.all.size(); ++bin) {
      const int from = made.low + static_cast<int>(bin) * made.width;
      std::uint64_t all = 0, body = 0;
      for (std::size_t at = 0; at < n; ++at) {
        const bool here = scan.grey.voxels[at] >= from && scan.grey.voxels[at] < from + made.width;
        all += here;
        body += here && scan.labels.voxels[at] != 0;
      }
      EXPECT_EQ(made.all[bin], all) << from;
      EXPECT_EQ(made.body[bin], body) << from;
      held += all;
    }
    EXPECT_EQ(held + made.below + made.above, n);
  }
}

TEST(Histogram, LeavesStrayValuesOutsideItsBins) {
  GreyVolume grey;
  grey.grid.size = {200, 100, 100};  // 2 million voxels: 20 at either end count as outliers
  grey.voxels.resize(grey.grid.count());
  for (std::size_t at = 0; at < grey.voxels.size(); ++at)
    grey.voxels[at] = static_cast<std::int16_t>(at % 100);
  for (std::size_t at = 0; at < 20; ++at) grey.voxels[1000 * at] = 30'000;
  for (std::size_t at = 0; at < 20; ++at) grey.voxels[1000 * at + 1] = -32'768;
  const Histogram made = histogram(grey, nullptr);
  EXPECT_EQ(made.low, 0);
  EXPECT_EQ(made.width, 1);
  EXPECT_EQ(made.all.size(), 100u);
  EXPECT_EQ(made.below, 20u);
  EXPECT_EQ(made.above, 20u);
  EXPECT_TRUE(made.body.empty());
  EXPECT_EQ(sum(made.all), grey.voxels.size() - 40);
  grey.voxels[7] = 30'000;  // one more is no outlier, so the bins include it
  const Histogram wide = histogram(grey, nullptr);
  EXPECT_EQ(wide.above, 0u);
  EXPECT_EQ(wide.width, 100);
  EXPECT_LE(wide.all.size(), 320u);
}

TEST(Histogram, HandlesConstantsAndLabelsOfAnotherGrid) {
  CapsuleScan scan = capsule_scan(capsule_grid(24));
  std::ranges::fill(scan.grey.voxels, std::int16_t{-1000});
  scan.labels.grid.origin[0] += 1;
  const Histogram made = histogram(scan.grey, &scan.labels);
  EXPECT_EQ(made.all, std::vector<std::uint64_t>{scan.grey.voxels.size()});
  EXPECT_EQ(made.low, -1000);
  EXPECT_TRUE(made.body.empty());
}

}  // namespace
}  // namespace borelli
