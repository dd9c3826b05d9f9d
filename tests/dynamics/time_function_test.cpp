// Functions of time: their derivatives against central differences.
#include "dynamics/numbers/time_function.hpp"

#include <gtest/gtest.h>

namespace borelli::test {
namespace {

void expect_derivatives(const TimeFunction& f, double t) {
  const double h = 1e-4;  // differences err by h^2 times the next derivatives, about 1e-7 here
  const TimeValue behind = at(f, t - h), now = at(f, t), ahead = at(f, t + h);
  EXPECT_NEAR(now.rate, (ahead.value - behind.value) / (2 * h), 1e-6);
  EXPECT_NEAR(now.acceleration, (ahead.rate - behind.rate) / (2 * h), 1e-6);
}

TEST(TimeFunction, PolynomialHasItsValuesAndDerivatives) {
  const TimeFunction f = Polynomial{{1, -2, 3, 0.5}};
  EXPECT_DOUBLE_EQ(at(f, 2).value, 1 - 4 + 12 + 4);
  EXPECT_DOUBLE_EQ(at(f, 2).rate, -2 + 12 + 6);
  EXPECT_DOUBLE_EQ(at(f, 2).acceleration, 6 + 6);
  expect_derivatives(f, 0.7);
}

TEST(TimeFunction, ConstantAndLinearArePolynomials) {
  EXPECT_DOUBLE_EQ(at(constant(3), 5).value, 3);
  EXPECT_DOUBLE_EQ(at(constant(3), 5).rate, 0);
  EXPECT_DOUBLE_EQ(at(linear(1, 2), 5).value, 11);
  EXPECT_DOUBLE_EQ(at(linear(1, 2), 5).rate, 2);
  EXPECT_DOUBLE_EQ(at(Polynomial{}, 5).value, 0);
}

TEST(TimeFunction, SineHasItsValuesAndDerivatives) {
  const TimeFunction f = Sine{.amplitude = 2, .angular_frequency = 3, .phase = 0.4, .offset = -1};
  EXPECT_DOUBLE_EQ(at(f, 0.5).value, -1 + 2 * std::sin(1.9));
  expect_derivatives(f, 0.7);
}

TEST(TimeFunction, TableHasItsValuesAndDerivatives) {
  const TimeFunction f = Table({0, 0.5, 1, 2}, {1, 3, -1, 0});
  EXPECT_DOUBLE_EQ(at(f, 0.5).value, 3);
  for (double t : {0.3, 0.7, 1.5, 2.5, -0.5}) expect_derivatives(f, t);
  EXPECT_EQ(complaint_of(f), "");
  Table changed({0, 1}, {0, 1});
  changed.times = {0, 2};
  EXPECT_EQ(complaint_of(changed), "its table was changed; call prepare()");
  EXPECT_EQ(complaint_of(Table({1, 0}, {0, 1})), "its table: its times must increase, but 0 comes after 1");
}

}  // namespace
}  // namespace borelli::test
