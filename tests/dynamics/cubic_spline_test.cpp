// The cubic spline: small cases by hand, its order on functions that satisfy its end conditions, and values
// beyond the ends.
#include "dynamics/numbers/cubic_spline.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace borelli::test {
namespace {

/// A spline of f with n equal pieces on [0, end].
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

TEST(CubicSpline, ThroughThreePointsMatchesHandCalculation) {
  // 2/3 M1 = -2, so M1 = -3; at 0.5: 0.5 + (0.125 - 0.5) (-3) / 6
  const CubicSpline s({0, 1, 2}, {0, 1, 0}, SplineEnds::natural);
  EXPECT_DOUBLE_EQ(s(0.5).value, 0.6875);
  EXPECT_DOUBLE_EQ(s(1.0).curvature, -3);
  EXPECT_DOUBLE_EQ(s(0.0).slope, 1.5);
  // level at both ends: two halves of 3 x^2 - 2 x^3
  const CubicSpline level({0, 1, 2}, {0, 1, 0}, SplineEnds::clamped);
  for (double x : {0.2, 0.7}) EXPECT_NEAR(level(x).value, 3 * x * x - 2 * x * x * x, 1e-15);
}

TEST(CubicSpline, IsOfFourthOrderWithExactEnds) {
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

TEST(CubicSpline, IsTwiceDifferentiableEverywhere) {
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

TEST(CubicSpline, ClampedSplineIsConstantBeyondItsEnds) {
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

TEST(CubicSpline, ExplainsInvalidTables) {
  using S = CubicSpline;
  EXPECT_EQ(S::complaint({0, 1}, {0, 1}, SplineEnds::natural), "");
  EXPECT_EQ(S::complaint({0}, {0}, SplineEnds::natural), "has 1 values, expected at least 2");
  EXPECT_EQ(S::complaint({0, 1}, {0}, SplineEnds::natural), "has 2 times and 1 values");
  EXPECT_EQ(S::complaint({0, 1, 1}, {0, 1, 2}, SplineEnds::natural),
            "its times must increase, but 1 comes after 1");
  EXPECT_EQ(S::complaint({0, 1, 2, 3}, {0, 1, 2, 3}, SplineEnds::periodic),
            "is periodic, but begins with 0 and ends with 3");
  EXPECT_EQ(S::complaint({0, NAN}, {0, 1}, SplineEnds::natural), "contains a number that is not finite");
}

/// The same conditions with the slopes as unknowns, in one dense system: continuous second derivatives, and
/// end pieces whose third derivative is that of the cubic through the four end values.
double forsythe_by_slopes(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const int n = int(x.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  const auto h = [&](int i) { return x[i + 1] - x[i]; };
  const auto rise = [&](int i) { return (y[i + 1] - y[i]) / h(i); };
  for (int i = 1; i + 1 < n; ++i) {
    A(i, i - 1) = 1 / h(i - 1);
    A(i, i) = 2 / h(i - 1) + 2 / h(i);
    A(i, i + 1) = 1 / h(i);
    b[i] = 3 * rise(i - 1) / h(i - 1) + 3 * rise(i) / h(i);
  }
  for (const int end : {0, n - 1}) {
    const int first = end == 0 ? 0 : n - 4, piece = end == 0 ? 0 : n - 2;
    Eigen::Matrix4d powers;
    Eigen::Vector4d values;
    for (int i = 0; i < 4; ++i) {
      values[i] = y[first + i];
      for (int p = 0; p < 4; ++p) powers(i, p) = std::pow(x[first + i], p);
    }
    // the third derivative of a Hermite piece: 6 (s0 + s1 - 2 rise) / h^2
    A(end, piece) = A(end, piece + 1) = 1;
    b[end] = 2 * rise(piece) + h(piece) * h(piece) * powers.fullPivLu().solve(values)[3];
  }
  const Eigen::VectorXd s = A.fullPivLu().solve(b);
  int i = 0;
  while (i + 2 < n && at > x[i + 1]) ++i;
  const double u = (at - x[i]) / h(i);
  return y[i] * (1 + 2 * u) * (1 - u) * (1 - u) + y[i + 1] * u * u * (3 - 2 * u) +
         h(i) * (s[i] * u * (1 - u) * (1 - u) - s[i + 1] * u * u * (1 - u));
}

TEST(CubicSpline, WithForsythesEndsReproducesCubics) {
  const auto cubic = [](double x) { return 0.3 - 2 * x + 0.7 * x * x - 0.4 * x * x * x; };
  const std::vector<double> x{-1, -0.2, 0.5, 0.9, 2};
  std::vector<double> y;
  for (const double at : x) y.push_back(cubic(at));
  const CubicSpline s(x, y, SplineEnds::forsythe);
  for (const double at : {-0.9, -0.3, 0.1, 0.8, 1.7}) {
    EXPECT_NEAR(s(at).value, cubic(at), 1e-14);
    EXPECT_NEAR(s(at).slope, -2 + 1.4 * at - 1.2 * at * at, 1e-13);
    EXPECT_NEAR(s(at).curvature, 1.4 - 2.4 * at, 1e-12);
  }
  const CubicSpline parabola({0, 1, 3}, {1, 2, 10}, SplineEnds::forsythe);  // 1 + x^2
  EXPECT_NEAR(parabola(2.0).value, 5, 1e-14);
  const CubicSpline line({0, 2}, {1, 2}, SplineEnds::forsythe);
  EXPECT_NEAR(line(1.0).value, 1.5, 1e-15);
}

TEST(CubicSpline, WithForsythesEndsMeetsItsConditionsOnUnevenData) {
  // OpenSim's tibia translation over the knee angle (gait10dof18musc)
  const std::vector<double> x{-2.0944,   -1.74533, -1.39626, -1.0472,  -0.698132, -0.349066,
                              -0.174533, 0.197344, 0.337395, 0.490178, 1.52146,   2.0944};
  const std::vector<double> y{-0.0032, 0.00179,   0.00411,   0.0041,    0.00212,   -0.001,
                              -0.0031, -0.005227, -0.005435, -0.005574, -0.005435, -0.00525};
  const CubicSpline s(x, y, SplineEnds::forsythe);
  for (int i = 0; i <= 100; ++i) {
    const double at = x.front() + (x.back() - x.front()) * i / 100;
    EXPECT_NEAR(s(at).value, forsythe_by_slopes(x, y, at), 1e-14);
  }
  const auto end = s(x.back());
  EXPECT_NEAR(s(x.back() + 0.5).value, end.value + 0.5 * end.slope, 1e-15);  // a line beyond the ends
  EXPECT_EQ(s(x.front() - 0.1).curvature, 0);
}

}  // namespace
}  // namespace borelli::test
