// Every explicit adaptive method at a jump of the function, at its end, and at values that are not finite.
#include <cmath>

#include "functions.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

const char* const methods[] = {"rk4_adaptive", "dopri5", "dop853", "gbs", "gbs4", "gbs6", "gbs8", "gauss16"};

TEST(AdaptiveMethods, ResolveAForceJumpAnywhereInAStep) {
  // x'' = 1, and 1000 after the jump; steps are as long as allowed, so that jumps fall anywhere in a step
  for (const char* name : methods)
    for (const double tolerance : {1e-6, 1e-10})
      for (int k = 0; k < 50; ++k) {
        const double leap = 0.31 + 0.013 * k;
        FunctionFlow flow(2, [&](double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
          dy << y[1], t < leap ? 1. : 1000.;
        });
        const auto method = need(make_integrator(name, tolerance));
        Eigen::VectorXd y = Eigen::VectorXd::Zero(2);
        const int steps = advance(flow, *method, y, 1);
        const double left = 1 - leap;
        EXPECT_NEAR(y[1], leap + 1000 * left, 10 * steps * tolerance) << name << ", " << leap;
        EXPECT_NEAR(y[0], 0.5 * leap * leap + leap * left + 500 * left * left, 10 * steps * tolerance)
            << name << ", " << leap;
      }
}

TEST(AdaptiveMethods, ShortenTheStepWhenTheFunctionFails) {
  for (const char* name : methods) {
    FunctionFlow flow(
        1, [](double, const Eigen::VectorXd&, Eigen::VectorXd& dy) { dy[0] = 1; }, 0.4);
    const auto method = need(make_integrator(name, 1e-6));
    const Eigen::VectorXd y = Eigen::VectorXd::Zero(1), dy = Eigen::VectorXd::Ones(1);
    Eigen::VectorXd out(1);
    const Attempt attempt = method->attempt(flow, 0, 1, y, dy, out);
    EXPECT_FALSE(attempt.evaluated) << name;
    EXPECT_FALSE(attempt.accepted) << name;
    EXPECT_DOUBLE_EQ(attempt.next_step, 0.25) << name;
  }
}

// One component becomes NaN within the step and does not act on the other. The other's small error must not
// hide it.
TEST(AdaptiveMethods, RejectStepsWhoseErrorIsNotANumber) {
  for (const char* name : methods)
    for (const int bad : {0, 1}) {
      FunctionFlow flow(2, [&](double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
        dy[bad] = t > 0.01 ? std::nan("") : 1;
        dy[1 - bad] = -y[1 - bad];
      });
      const auto method = need(make_integrator(name, 1e-6));
      Eigen::VectorXd y = Eigen::VectorXd::Ones(2), dy(2), out(2);
      flow.derivative(0, y, dy);
      const Attempt attempt = method->attempt(flow, 0, 0.1, y, dy, out);
      EXPECT_FALSE(attempt.accepted) << name << ", " << bad;
      EXPECT_LT(attempt.next_step, 0.1) << name << ", " << bad;
      EXPECT_GT(attempt.next_step, 0) << name << ", " << bad;
    }
}

}  // namespace
}  // namespace borelli::test
