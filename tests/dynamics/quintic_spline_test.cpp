// The quintic spline against SciPy's make_interp_spline(k=5) with zero third and fourth derivatives at both
// ends.
#include "dynamics/inverse/quintic_spline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace borelli::test::quintic_spline_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(QuinticSpline, EqualsScipysNaturalSpline) {
  const std::vector<double> times{0, 0.1, 0.25, 0.3, 0.55, 0.7, 1.0, 1.1};
  MatrixXd values(8, 1);
  values << 1.0, 0.5, -0.3, -0.2, 0.8, 1.4, 0.2, 0.1;
  const auto spline = QuinticSpline::through(times, values);
  ASSERT_TRUE(spline);
  // t, value, first and second derivative by SciPy 1.10
  const double expected[7][4] = {{0.0, 1.0, -2.2812960889805964, -57.228871459846914},
                                 {0.07, 0.702497564193512, -6.115958126971368, -47.43693064850217},
                                 {0.2, -0.18821336734155292, -4.515079356211519, 82.86731037295145},
                                 {0.28, -0.25936808204604966, 2.4404922656042856, 60.97601770113466},
                                 {0.5, 0.5835713030188531, 4.016796627905305, 10.996715375962014},
                                 {0.9, 0.723121669167602, -6.202401894661696, 2.9908343649471414},
                                 {1.1, 0.1, 1.6611622073433456, 54.05901098676836}};
  VectorXd value, rate, second;
  for (const auto& row : expected) {
    spline->at(row[0], value, rate, second);
    EXPECT_NEAR(value[0], row[1], 1e-11);  // rounding of two eliminations
    EXPECT_NEAR(rate[0], row[2], 1e-10);
    EXPECT_NEAR(second[0], row[3], 1e-8);
  }
}

TEST(QuinticSpline, ErrorInTheMiddleFallsWithTheSixthPowerOfTheStep) {
  double before = 0;
  for (int n : {21, 41, 81}) {
    std::vector<double> times;
    MatrixXd values(n, 2);
    for (int i = 0; i < n; ++i) {
      times.push_back(4.0 * i / (n - 1));
      values.row(i) << std::sin(3 * times.back()), std::exp(-times.back());
    }
    const auto spline = QuinticSpline::through(times, values);
    ASSERT_TRUE(spline);
    VectorXd value, rate, second;
    double error = 0;
    for (double t = 1.7; t < 2.3; t += 0.013) {
      spline->at(t, value, rate, second);
      error = std::max({error, std::abs(value[0] - std::sin(3 * t)), std::abs(value[1] - std::exp(-t))});
    }
    if (before > 0) {
      EXPECT_GT(before / error, 40);  // 2^6 = 64, less the effect of the ends
    }
    before = error;
  }
}

TEST(QuinticSpline, RefusesInvalidData) {
  const MatrixXd values = MatrixXd::Zero(3, 1);
  EXPECT_FALSE(QuinticSpline::through({0, 1}, MatrixXd::Zero(2, 1)));
  EXPECT_FALSE(QuinticSpline::through({0, 1, 1}, values));
  EXPECT_FALSE(QuinticSpline::through({0, 1, std::numeric_limits<double>::quiet_NaN()}, values));
  EXPECT_FALSE(QuinticSpline::through({0, 1, 2, 3}, values));
  MatrixXd gap = values;
  gap(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(QuinticSpline::through({0, 1, 2}, gap));
}

}  // namespace
}  // namespace borelli::test::quintic_spline_test
