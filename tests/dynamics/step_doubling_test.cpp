// Step doubling: the order of its extrapolation, steps chosen by the error, and evaluations as counted by
// Press et al.
#include "dynamics/methods/step_doubling.hpp"

#include <cmath>

#include "functions.hpp"

namespace borelli::test {
namespace {

TEST(StepDoubling, LocalExtrapolationAddsAnOrder) {
  const auto error = [](int steps) {
    FunctionFlow flow = bernoulli();
    StepDoubling method(classical_runge_kutta(), 1);  // any step is accepted
    EXPECT_EQ(method.order(), 5);
    return std::abs(integrate(flow, method, Eigen::VectorXd::Constant(1, 0.5), 2, steps)[0] -
                    1 / (2 + std::sin(2.0)));
  };
  EXPECT_NEAR(std::log2(error(10) / error(20)), 5, 0.35);  // the next order's term is large at so few steps
}

TEST(StepDoubling, TakesElevenEvaluationsAStep) {
  FunctionFlow flow = bernoulli();
  StepDoubling method(classical_runge_kutta(), 1);
  integrate(flow, method, Eigen::VectorXd::Constant(1, 0.5), 1, 3);
  EXPECT_EQ(flow.evaluations, 3 * 11);
}

TEST(StepDoubling, ProposesAStepThatMeetsTheTolerance) {
  FunctionFlow flow = bernoulli();
  const Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 0.5);
  Eigen::VectorXd dy(1), out(1);
  flow.derivative(0, y, dy);
  StepDoubling method(classical_runge_kutta(), 1e-9);
  const Attempt large = method.attempt(flow, 0, 1, y, dy, out);
  EXPECT_FALSE(large.accepted);
  EXPECT_EQ(large.worst, 0);
  double h = large.next_step;
  Attempt attempt;
  for (int i = 0; i < 6 && !(attempt = method.attempt(flow, 0, h, y, dy, out)).accepted; ++i)
    h = attempt.next_step;
  ASSERT_TRUE(attempt.accepted);
  EXPECT_LT(std::abs(out[0] - 1 / (2 + std::sin(h))), 1e-9);
  EXPECT_GT(attempt.next_step, 0.5 * h);
  EXPECT_LE(attempt.next_step, 4 * h);
}

}  // namespace
}  // namespace borelli::test
