// Collocation at eight nodes: exactness, tolerance, lanes, stiffness.
#include "dynamics/methods/collocation.hpp"

#include <complex>
#include <utility>

#include "each_width.hpp"
#include "functions.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

// Of the integral of the sixteenth power the rule of Gauss misses 8!^4 / 16!^2, 6e-9 (Abramowitz and Stegun,
// 25.4.30, on the interval from 0 to 1).
TEST(Collocation, IsExactForPolynomialsOfDegreeFifteen) {
  const double missed = std::pow(std::tgamma(9.), 4) / std::pow(std::tgamma(17.), 2);
  for (int degree = 0; degree <= 16; ++degree) {
    FunctionFlow flow(1, [&](double t, const Eigen::VectorXd&, Eigen::VectorXd& dy) {
      dy[0] = (degree + 1) * std::pow(t, degree);
    });
    Collocation method(1e9);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(1), dy(1), out(1);
    flow.derivative(0, y, dy);
    ASSERT_TRUE(method.attempt(flow, 0, 1, y, dy, out).evaluated);
    EXPECT_NEAR(out[0], degree < 16 ? 1 : 1 - missed, 2e-15) << degree;
  }
}

/// x'' = -x, which tells the method which component is the position.
struct Oscillator : FunctionFlow {
  Oscillator()
      : FunctionFlow(2, [](double, const Eigen::VectorXd& y, Eigen::VectorXd& dy) { dy << y[1], -y[0]; }) {}
  Eigen::Index positions() const override { return 1; }
  void position_rates(const Eigen::VectorX<Lanes>& y, Eigen::VectorX<Lanes>& dy) override { dy[0] = y[1]; }
};

class CollocationInRegisters : public EachWidth {};
INSTANTIATE_TEST_SUITE_P(OfEachWidth, CollocationInRegisters, ::testing::ValuesIn(all_widths()));

// Of linear equations Gauss' collocation makes the diagonal Pade approximant to the exponential function
// (Hairer, Wanner, Solving ODEs II, section IV.5): its phase is 5e-11 off after a step of 3.1.
TEST_P(CollocationInRegisters, EqualsThePadeApproximant) {
  const std::complex<double> z(0, 3.1);
  std::complex<double> up = 0, power = 1;
  double factor = 1;
  for (int k = 0; k <= 8; ++k) {
    up += factor * power;
    power *= z;
    factor *= (8 - k) / ((16. - k) * (k + 1));
  }
  const std::complex<double> approximant = up / std::conj(up);
  Oscillator flow;
  Collocation method(1e-10);
  Eigen::VectorXd y(2), dy(2), out(2);
  y << 1, 0;
  flow.derivative(0, y, dy);
  ASSERT_TRUE(method.attempt(flow, 0, z.imag(), y, dy, out).evaluated);
  EXPECT_NEAR(out[0], approximant.real(), 2e-12);
  EXPECT_NEAR(out[1], -approximant.imag(), 2e-12);
  EXPECT_GT(std::abs(approximant - std::exp(z)), 3e-11);
}

TEST_P(CollocationInRegisters, MeetsItsTolerance) {
  for (double tolerance : {1e-3, 1e-6, 1e-9, 1e-12}) {
    FunctionFlow flow = bernoulli();
    Collocation method(tolerance);
    Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 0.5);
    const int steps = advance(flow, method, y, 10);
    // one tolerance per step at most, which grows as y^2: ninefold from y = 1/3 to y = 1
    EXPECT_LT(std::abs(y[0] - 1 / (2 + std::sin(10.0))), 9 * steps * tolerance) << tolerance;
  }
}

// Slopes are evaluated four at a time. For a tight tolerance there are fewer than dop853's, for a loose one
// up to twice as many.
TEST_P(CollocationInRegisters, IntegratesMotionsWithFewEvaluations) {
  const Scene scene = chain(3, false, 0.5);
  const auto by = [&](const char* method, double tolerance) {
    SimulationSettings how = settings(method, 5, 1e-3, tolerance);
    how.output_interval = how.end_time;  // outputs cut steps short, but not those of dop853
    return run(scene, how);
  };
  const Eigen::VectorXd truth = last(by("dop853", 1e-14).q);
  for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12}) {
    const Trajectory a = by("gauss16", tolerance), b = by("dop853", tolerance);
    const long most = (tolerance > 1e-9 ? 2 : 1) * b.certificate.evaluations;
    EXPECT_LT(a.certificate.evaluations, most) << tolerance;
    // one tolerance per step at most
    EXPECT_LT((last(a.q) - truth).norm(), double(a.certificate.steps_accepted) * tolerance) << tolerance;
  }
}

TEST(Collocation, StepSizeFollowsTheOrder) {
  const auto steps_to = [&](double tolerance) {
    FunctionFlow flow = bernoulli();
    Collocation method(tolerance);
    Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 0.5);
    return double(advance(flow, method, y, 200));
  };
  EXPECT_NEAR(std::log10(steps_to(1e-12) / steps_to(1e-6)), 6. / 17, 0.1);
}

// A large smooth component must not hide a small fast one, whose integral is the error function.
TEST(Collocation, ResolvesSmallComponentsBesideLargeOnes) {
  for (const double width : {0.1, 0.3, 1.})
    for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12})
      for (const double size : {1e-1, 1e-3, 1e-5}) {
        FunctionFlow flow(2, [&](double t, const Eigen::VectorXd&, Eigen::VectorXd& dy) {
          dy << std::cos(t), size * std::exp(-std::pow((t - 3) / width, 2));
        });
        Collocation method(tolerance);
        Eigen::VectorXd y = Eigen::VectorXd::Zero(2);
        const int steps = advance(flow, method, y, 6);
        EXPECT_NEAR(y[1], size * width * std::sqrt(M_PI) * std::erf(3 / width), steps * tolerance)
            << width << ", " << tolerance << ", " << size;
      }
}

TEST(Collocation, WorkThatIsNotANumberShortensTheStep) {
  // beside position and velocity a third component, which does not act on them
  struct Working : FunctionFlow {
    Working()
        : FunctionFlow(3, [](double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
            dy << y[1], -y[0], t > 0.3 ? std::nan("") : 1;
          }) {}
    Eigen::Index positions() const override { return 1; }
    void position_rates(const Eigen::VectorX<Lanes>& y, Eigen::VectorX<Lanes>& dy) override { dy[0] = y[1]; }
  } flow;
  Collocation method(1e-6);
  Eigen::VectorXd y(3), dy(3), out(3);
  y << 1, 0, 0;
  flow.derivative(0, y, dy);
  const Attempt attempt = method.attempt(flow, 0, 1, y, dy, out);
  EXPECT_FALSE(attempt.accepted);
  EXPECT_DOUBLE_EQ(attempt.next_step, 0.5);
}

// In parallel, nodes do not wait for each other even in the first iteration, so the iterates differ.
TEST_P(CollocationInRegisters, ParallelNodesConvergeToTheSequentialResult) {
  const auto run = [](SpringsInLanes& flow, double tolerance) {
    Collocation method(tolerance);
    Eigen::VectorXd y(4);
    y << 1, -0.3, 0.2, 0.7;
    advance(flow, method, y, 20);
    return y;
  };
  SpringsInLanes flow;
  flow.in_lanes = false;
  const Eigen::VectorXd tight = run(flow, 1e-15);
  EXPECT_EQ(flow.calls, 0);
  flow.evaluations = 0;
  EXPECT_LT((run(flow, 1e-10) - tight).norm(), 1e-10);
  const int one_by_one = std::exchange(flow.evaluations, 0);
  flow.in_lanes = true;
  EXPECT_LT((run(flow, 1e-10) - tight).norm(), 1e-10);
  EXPECT_LT(flow.evaluations, 1.1 * one_by_one);
  EXPECT_GT(flow.calls, flow.evaluations / 9);
  EXPECT_LT(flow.calls, flow.evaluations / 8);
}

TEST(Collocation, StiffnessShortensStepsButKeepsAccuracy) {
  // the rounds settle while steps are shorter than about thousandths
  FunctionFlow flow(1, [](double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
    dy[0] = -1000 * (y[0] - std::cos(t)) - std::sin(t);
  });
  Collocation method(1e-8);
  Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 2);
  const int steps = advance(flow, method, y, 3);
  EXPECT_NEAR(y[0], std::cos(3.), 1e-8);
  EXPECT_GT(steps, 100);
  EXPECT_LT(steps, 5000);
}

TEST(Collocation, RejectedAttemptsLeaveNoTrace) {
  FunctionFlow flow = bernoulli();
  Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 0.5), dy(1), out(1), part(1), after[2];
  for (const bool looked : {false, true}) {
    Collocation method(1e-10);
    flow.derivative(0, y, dy);
    ASSERT_TRUE(method.attempt(flow, 0, 0.2, y, dy, out).accepted);
    if (looked)
      for (const double h : {0.19, 0.05, 0.12}) {
        ASSERT_TRUE(method.shortened(flow, 0, h, y, dy, part));
        EXPECT_NEAR(part[0], 1 / (2 + std::sin(h)), 1e-10);
      }
    flow.derivative(0.2, out, dy);
    after[looked].resize(1);
    ASSERT_TRUE(method.attempt(flow, 0.2, 0.2, out, dy, after[looked]).accepted);
  }
  EXPECT_EQ(after[0], after[1]);
}

}  // namespace
}  // namespace borelli::test
