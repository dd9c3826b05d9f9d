// Orders of the fixed-step methods on problems with closed solutions, one of them depending on time
// explicitly.
#include "dynamics/methods/explicit_runge_kutta.hpp"

#include <cmath>
#include <functional>

#include "functions.hpp"

namespace borelli::test {
namespace {

double error_at_end(const Tableau& tableau, int steps) {
  // y' = -y^2 cos t, y(0) = 1/2: y = 1 / (2 + sin t)
  FunctionFlow flow(
      1, [](double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) { dy[0] = -y[0] * y[0] * std::cos(t); });
  ExplicitRungeKutta method(tableau);
  const Eigen::VectorXd end = integrate(flow, method, Eigen::VectorXd::Constant(1, 0.5), 2, steps);
  return std::abs(end[0] - 1 / (2 + std::sin(2.0)));
}

void expect_order(const Tableau& tableau) {
  ASSERT_EQ(ExplicitRungeKutta(tableau).order(), tableau.order);
  const double coarse = error_at_end(tableau, 40), fine = error_at_end(tableau, 80);
  // the next order's term at these steps, about 5 %, changes the order by 0.1
  EXPECT_NEAR(std::log2(coarse / fine), tableau.order, 0.15);
}

TEST(ExplicitRungeKutta, EulerIsOfFirstOrder) { expect_order(euler()); }
TEST(ExplicitRungeKutta, MidpointIsOfSecondOrder) { expect_order(midpoint()); }
TEST(ExplicitRungeKutta, ClassicalIsOfFourthOrder) { expect_order(classical_runge_kutta()); }

TEST(ExplicitRungeKutta, SaysWhenTheFunctionCannotBeEvaluated) {
  FunctionFlow flow(
      1, [](double, const Eigen::VectorXd&, Eigen::VectorXd&) {}, 1.2);
  ExplicitRungeKutta method(classical_runge_kutta());
  const Eigen::VectorXd y = Eigen::VectorXd::Zero(1);
  Eigen::VectorXd out(1);
  EXPECT_TRUE(method.attempt(flow, 0, 1, y, y, out).evaluated);
  EXPECT_FALSE(method.attempt(flow, 1, 1, y, y, out).evaluated);
}

}  // namespace
}  // namespace borelli::test
