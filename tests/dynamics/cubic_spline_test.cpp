// The cubic spline: small ones by hand, its order against functions that meet its ends, what holds beyond
// them.
#include "dynamics/numbers/cubic_spline.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli::test {
namespace {

/// Through n even pieces of f over [0, end].
template <class Function>
CubicSpline through(const Function& f, double end, int n, SplineEnds ends) {
  std::vector<double> x, y;
  for (int i = 0; i <= n; ++i) {
    x.push_back(end * i / n);
    y.push_back(f(x.back()));
  }
  if (ends == SplineEnds::periodic) y.back() = y.front();
  return CubicSpline(x, y, ends);
}

TEST(CubicSpline, OfThreePointsIsThatByHand) {
  // 2/3 M1 = -2, so M1 = -3; at 0.5: 0.5 + (0.125 - 0.5) (-3) / 6
  const CubicSpline s({0, 1, 2}, {0, 1, 0}, SplineEnds::natural);
  EXPECT_DOUBLE_EQ(s(0.5).value, 0.6875);
  EXPECT_DOUBLE_EQ(s(1.0).curvature, -3);
  EXPECT_DOUBLE_EQ(s(0.0).slope, 1.5);
  // level at both ends: two halves of 3 x^2 - 2 x^3
  const CubicSpline level({0, 1, 2}, {0, 1, 0}, SplineEnds::clamped);
  for (double x : {0.2, 0.7}) EXPECT_NEAR(level(x).value, 3 * x * x - 2 * x * x * x, 1e-15);
}

TEST(CubicSpline, IsOfFourthOrderWhereItsEndsAreTheFunctions) {
  const auto error = [](auto f, double end, int n, SplineEnds ends) {
    const CubicSpline s = through(f, end, n, ends);
    double largest = 0;
    for (int i = 0; i <= 1000; ++i)
      largest = std::max(largest, std::abs(s(end * i / 1000).value - f(end * i / 1000)));
    return largest;
  };
  const auto sine = [](double x) { return std::sin(x); };
  const auto cosine = [](double x) { return std::cos(x); };
  const auto expect_fourth = [&](auto f, double end, SplineEnds ends) {
    const double coarse = error(f, end, 20, ends), fine = error(f, end, 40, ends);
    EXPECT_NEAR(std::log2(coarse / fine), 4, 0.1) << coarse << " and " << fine;
  };
  expect_fourth(sine, M_PI, SplineEnds::natural);
  expect_fourth(cosine, M_PI, SplineEnds::clamped);
  expect_fourth(sine, 2 * M_PI, SplineEnds::periodic);
  expect_fourth(cosine, 2 * M_PI, SplineEnds::periodic);
}

TEST(CubicSpline, IsTwiceDifferentiableAtItsPointsAndBeyondItsEnds) {
  const std::vector<double> x{0, 0.3, 1, 1.2, 2.5}, y{1, -2, 0.5, 0.7, 1};
  for (SplineEnds ends : {SplineEnds::natural, SplineEnds::clamped, SplineEnds::periodic}) {
    const CubicSpline s(x, y, ends);
    const double h = 1e-9;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto before = s(x[i] - h), after = s(x[i] + h);
      EXPECT_NEAR(s(x[i]).value, y[i], 1e-14);
      EXPECT_NEAR(before.value, after.value, 1e-7);
      EXPECT_NEAR(before.slope, after.slope, 1e-6);
      if (ends != SplineEnds::clamped || (i > 0 && i + 1 < x.size())) {
        EXPECT_NEAR(before.curvature, after.curvature, 1e-5);
      }
    }
    EXPECT_NEAR(s(0.7).slope, (s(0.7 + 1e-5).value - s(0.7 - 1e-5).value) / 2e-5, 1e-8);
    EXPECT_NEAR(s(0.7).curvature, (s(0.7 + 1e-5).slope - s(0.7 - 1e-5).slope) / 2e-5, 1e-7);
  }
  EXPECT_NEAR(CubicSpline(x, y, SplineEnds::periodic)(0.4 + 5).value,
              CubicSpline(x, y, SplineEnds::periodic)(0.4).value, 1e-13);
  EXPECT_DOUBLE_EQ(CubicSpline(x, y, SplineEnds::clamped)(9.0).value, 1);
  EXPECT_DOUBLE_EQ(CubicSpline(x, y, SplineEnds::natural)(9.0).curvature, 0);
}

TEST(CubicSpline, ClampedIsLevelBeyondItsEndsToTheLastDigit) {
  const CubicSpline spline({0.1, 0.3, 0.35, 0.7}, {0.3, 1e7, -0.7, 0.1}, SplineEnds::clamped);
  for (const double x : {-5., 0., 0.0999}) {
    EXPECT_EQ(spline(x).value, 0.3);
    EXPECT_EQ(spline(x).slope, 0);
  }
  for (const double x : {0.71, 3., 1e6}) {
    EXPECT_EQ(spline(x).value, 0.1);
    EXPECT_EQ(spline(x).slope, 0);
  }
}

TEST(CubicSpline, SaysWhyThereIsNone) {
  using S = CubicSpline;
  EXPECT_EQ(S::complaint({0, 1}, {0, 1}, SplineEnds::natural), "");
  EXPECT_EQ(S::complaint({0}, {0}, SplineEnds::natural), "has 1 values, expected 2 at least");
  EXPECT_EQ(S::complaint({0, 1}, {0}, SplineEnds::natural), "has 2 places and 1 values");
  EXPECT_EQ(S::complaint({0, 1, 1}, {0, 1, 2}, SplineEnds::natural),
            "its places must rise, but 1 comes after 1");
  EXPECT_EQ(S::complaint({0, 1, 2, 3}, {0, 1, 2, 3}, SplineEnds::periodic),
            "is periodic, but begins with 0 and ends with 3");
  EXPECT_EQ(S::complaint({0, NAN}, {0, 1}, SplineEnds::natural),
            "holds something that is not a finite number");
}

}  // namespace
}  // namespace borelli::test
