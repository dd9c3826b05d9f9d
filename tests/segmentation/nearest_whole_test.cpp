#include "segmentation/volume/nearest_whole.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace borelli {
namespace {

TEST(NearestWhole, EqualsTheStandardLibrary) {
  for (double whole = -3; whole <= 3; ++whole)
    for (const double rest : {0.0, 0.25, 0.5, 0.75}) {
      const double x = whole + rest;
      for (const double at : {std::nextafter(x, -1e9), x, std::nextafter(x, 1e9)})
        EXPECT_EQ(nearest_whole(at), std::lround(at)) << at;
    }
  std::mt19937 random(1);
  for (const double wide : {1.0, 1e3, 1e9, 1e15}) {
    std::uniform_real_distribution<double> within(-wide, wide);
    for (int n = 0; n < 10000; ++n) {
      const double x = within(random);
      EXPECT_EQ(nearest_whole(x), std::lround(x)) << x;
    }
  }
}

}  // namespace
}  // namespace borelli
