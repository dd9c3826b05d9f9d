#include "segmentation/labelling/seen_border.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

// Muscle up to x = 10 mm and from 30 mm on, with fat in between and a layer of `hu`, `thick` mm wide, centred
// on `middle`; voxels of 1 mm hold means.
GreyVolume layers(double middle, double thick, double hu) {
  GreyVolume scan;
  scan.grid.size = {60, 20, 20};
  scan.quantity = Quantity::hu;
  scan.voxels.resize(scan.grid.count());
  for (std::int64_t k = 0; k < 20; ++k)
    for (std::int64_t j = 0; j < 20; ++j)
      for (std::int64_t i = 0; i < 60; ++i) {
        double sum = 0;
        for (int n = 0; n < 10; ++n) {
          const double x = static_cast<double>(i) - 0.45 + 0.1 * n;
          sum += std::abs(x - middle) < thick / 2 ? hu : x < 10 || x > 30 ? 50 : -100;
        }
        scan.voxels[scan.grid.offset(i, j, k)] = static_cast<std::int16_t>(std::lround(sum / 10));
      }
  return scan;
}

std::optional<double> border(const GreyVolume& scan, double at) {
  return seen_border(ScanProfile(scan), {10, 10, 10}, {at, 10, 10}, {30, 10, 10}, 10);
}

TEST(SeenBorder, LiesAtTheSkinsWhereverThePathPasses) {
  for (const double middle : {16.0, 20.3, 25.0})
    for (const double at : {12.0, 18.0, 27.0}) {
      const auto found = border(layers(middle, 3.5, 40), at);
      ASSERT_TRUE(found) << middle << " " << at;
      // some sample of the sheet's flat top
      EXPECT_NEAR(*found, middle - 10, 0.5 * 3.5) << middle << " " << at;
    }
}

TEST(SeenBorder, LiesInRemainingAir) {
  const auto found = border(layers(22, 3, -1000), 14);
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, 12, 1.5);
}

TEST(SeenBorder, IsAbsentInFatAlone) { EXPECT_FALSE(border(layers(20, 4, -100), 17)); }

TEST(SeenBorder, IsAbsentInLayersHardlyDenserThanFat) { EXPECT_FALSE(border(layers(20, 4, -60), 17)); }

}  // namespace
}  // namespace borelli
