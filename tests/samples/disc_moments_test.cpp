#include "samples/disc_moments.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace borelli {
namespace {

using Eigen::Vector2d;
constexpr double pi = std::numbers::pi;
constexpr double rounding = 1e-14;  // a few dozen terms of order one

PlaneMoments moments(std::vector<HalfPlane> cuts) { return disc_moments(cuts); }

void expect_near(const PlaneMoments& found, const PlaneMoments& expected, double tolerance) {
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), tolerance) << found.transpose() << "\nexpected\n"
                                                                 << expected.transpose();
}

TEST(DiscMoments, WholeDisc) {
  PlaneMoments expected;
  expected << pi, 0, 0, pi / 4, pi / 4, 0;
  expect_near(moments({}), expected, rounding);
  expect_near(moments({{{1, 0}, 1.5}}), expected, rounding);
  expect_near(moments({{{1, 0}, -1.5}}), PlaneMoments::Zero(), rounding);
}

TEST(DiscMoments, HalfAndQuarterDisc) {
  PlaneMoments half;
  half << pi / 2, -2. / 3, 0, pi / 8, pi / 8, 0;
  expect_near(moments({{{1, 0}, 0}}), half, rounding);
  PlaneMoments quarter;
  quarter << pi / 4, 1. / 3, 1. / 3, pi / 16, pi / 16, 1. / 8;
  expect_near(moments({{{-1, 0}, 0}, {{0, -1}, 0}}), quarter, rounding);
}

// segment beyond x = d: area acos d - d sqrt(1 - d^2), first moment 2/3 (1 - d^2)^(3/2)
TEST(DiscMoments, CircularSegment) {
  for (const double d : {-0.9, -0.2, 0.4, 0.999}) {
    const double half = std::sqrt(1 - d * d);
    const PlaneMoments m = moments({{{-1, 0}, -d}});
    EXPECT_NEAR(m[0], std::acos(d) - d * half, rounding);
    EXPECT_NEAR(m[1], 2. / 3 * half * half * half, rounding);
    EXPECT_NEAR(m[2], 0, rounding);
  }
}

TEST(DiscMoments, PolygonInsideTheDisc) {
  // the rectangle [-0.3, 0.5] x [0.1, 0.6]
  const PlaneMoments m = moments({{{1, 0}, 0.5}, {{-1, 0}, 0.3}, {{0, 1}, 0.6}, {{0, -1}, -0.1}});
  PlaneMoments expected;
  expected << 0.4, 0.4 * 0.1, 0.4 * 0.35, 0.5 * (0.125 + 0.027) / 3, 0.8 * (0.216 - 0.001) / 3, 0.04 * 0.35;
  expect_near(m, expected, rounding);
}

TEST(DiscMoments, HandlesEmptyAndRepeatedCuts) {
  expect_near(moments({{{1, 0}, -0.2}, {{-1, 0}, 0.1}}), PlaneMoments::Zero(), rounding);
  const HalfPlane cut{Vector2d(0.6, 0.8), 0.3};
  expect_near(moments({cut, cut, {cut.normal, 0.5}}), moments({cut}), rounding);
}

// Random cuts against integration over y of the segments that remain on lines y = const, by the midpoint
// rule. Its error with n lines is of order n^-3/2 here (square roots at the ends): 1e-7 for 100 000 lines.
TEST(DiscMoments, AnyCutsMatchStripIntegration) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<HalfPlane> cuts;
    for (int c = 0; c < 1 + trial % 5; ++c) {
      const double angle = pi * uniform(random);
      cuts.push_back({{std::cos(angle), std::sin(angle)}, 0.8 * uniform(random) + 0.2});
    }
    constexpr int lines = 100000;
    PlaneMoments sum = PlaneMoments::Zero();
    for (int n = 0; n < lines; ++n) {
      const double y = -1 + (2 * n + 1.0) / lines;
      double to = std::sqrt(1 - y * y), from = -to;
      for (const HalfPlane& cut : cuts) {
        const double at = (cut.offset - cut.normal.y() * y) / cut.normal.x();
        if (cut.normal.x() > 0)
          to = std::min(to, at);
        else
          from = std::max(from, at);
      }
      if (to <= from) continue;
      const double length = to - from, x = (to * to - from * from) / 2;
      PlaneMoments line;
      line << length, x, y * length, (to * to * to - from * from * from) / 3, y * y * length, y * x;
      sum += line * (2.0 / lines);
    }
    expect_near(disc_moments(cuts), sum, 3e-7);
  }
}

}  // namespace
}  // namespace borelli
