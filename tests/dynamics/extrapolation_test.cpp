// Extrapolation: each row's order, the tolerance, and the choice of order and step.
#include "dynamics/methods/extrapolation.hpp"

#include <cmath>

#include "functions.hpp"

namespace borelli::test {
namespace {

TEST(Extrapolation, EachRowAddsTwoOrders) {
  // a tolerance that any error meets is met by the row before the target row: row 2, of order 4
  FunctionFlow flow = bernoulli();
  const auto error = [&](int steps) {
    Extrapolation method(1e9);
    Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 0.5), dy(1), out(1);
    for (int i = 0; i < steps; ++i) {
      method.reset();
      flow.derivative(2.0 * i / steps, y, dy);
      EXPECT_TRUE(method.attempt(flow, 2.0 * i / steps, 2.0 / steps, y, dy, out).accepted);
      y = out;
    }
    return std::abs(y[0] - 1 / (2 + std::sin(2.0)));
  };
  EXPECT_NEAR(std::log2(error(16) / error(32)), 4, 0.3);
}

TEST(Extrapolation, NeedsFewEvaluationsAtTightTolerances) {
  for (double tolerance : {1e-6, 1e-9, 1e-12}) {
    FunctionFlow flow = bernoulli();
    Extrapolation method(tolerance);
    EXPECT_GE(method.order(), 6);
    Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 0.5);
    const int steps = advance(flow, method, y, 10);
    // one tolerance per step at most, which grows as y^2: ninefold from y = 1/3 to y = 1
    EXPECT_LT(std::abs(y[0] - 1 / (2 + std::sin(10.0))), 9 * steps * tolerance) << tolerance;
    // a step's last slope is the first of the next; classical Runge-Kutta needs 4e5 slopes for 1e-12
    EXPECT_LT(flow.evaluations - steps, 900) << tolerance;
  }
}

TEST(Extrapolation, FixedOrderMeetsItsToleranceAtItsCost) {
  // the number of steps scales as the tolerance to the power -1 / (order - 1)
  for (int rows = 2; rows <= 4; ++rows) {
    const auto steps_to = [&](double tolerance) {
      FunctionFlow flow = bernoulli();
      Extrapolation method(tolerance, rows);
      EXPECT_EQ(method.order(), 2 * rows);
      Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 0.5);
      const int steps = advance(flow, method, y, 10);
      EXPECT_LT(std::abs(y[0] - 1 / (2 + std::sin(10.0))), 9 * steps * tolerance)
          << rows << ", " << tolerance;
      return double(steps);
    };
    EXPECT_NEAR(std::log10(steps_to(1e-9) / steps_to(1e-6)), 3. / (2 * rows - 1), 0.15) << rows;
  }
}

// Rows 1 to n by 2, 4, ..., 2 n substeps ask for n^2 slopes beside the first, in any order.
TEST(Extrapolation, ParallelRowsEqualSequentialRows) {
  for (int rows = 4; rows <= 8; ++rows) {
    Eigen::VectorXd y(4), dy(4), at_once(4), one_by_one(4);
    y << 1, -0.3, 0.2, 0.7;
    SpringsInLanes flow;
    flow.derivative(0, y, dy);
    const auto attempt = [&](bool in_lanes, Eigen::VectorXd& out) {
      flow.in_lanes = in_lanes;
      flow.evaluations = flow.calls = 0;
      Extrapolation method(1e-3, rows);
      const Attempt made = method.attempt(flow, 0, 0.8, y, dy, out);
      EXPECT_TRUE(made.accepted) << rows;
      EXPECT_EQ(flow.evaluations, rows * rows + 1) << rows;  // the last: the slope at the end
      Eigen::VectorXd half(4), again(4);
      EXPECT_TRUE(method.shortened(flow, 0, 0.4, y, dy, half));
      flow.in_lanes = false;
      EXPECT_TRUE(Extrapolation(1e-3, rows).attempt(flow, 0, 0.4, y, dy, again).accepted);
      EXPECT_LT((half - again).norm(), 1e-13);
      return made;
    };
    const Attempt lanes = attempt(true, at_once), single = attempt(false, one_by_one);
    // rounding, which the last rows' weights multiply by hundreds
    EXPECT_LT((at_once - one_by_one).norm(), 1e-13) << rows;
    // it follows from the last rows' difference, with larger relative rounding
    EXPECT_NEAR(lanes.next_step, single.next_step, 1e-6 * single.next_step) << rows;
    EXPECT_EQ(lanes.worst, single.worst) << rows;
  }
}

TEST(Extrapolation, ParallelRowsCostLittleMoreThanTheLongest) {
  for (int rows = 4; rows <= 8; ++rows) {
    SpringsInLanes flow;
    Eigen::VectorXd y(4), dy(4), out(4);
    y << 1, -0.3, 0.2, 0.7;
    flow.derivative(0, y, dy);
    Extrapolation(1e-3, rows).attempt(flow, 0, 0.8, y, dy, out);
    EXPECT_EQ(flow.calls, rows < 8 ? 2 * rows - 1 : 16) << rows;  // 8^2 slopes fill 16 times four lanes
  }
}

TEST(Extrapolation, ParallelRowsMeetTheTolerance) {
  const auto end_of = [](bool in_lanes, double tolerance, Eigen::VectorXd& y) {
    SpringsInLanes flow;
    flow.in_lanes = in_lanes;
    Extrapolation method(tolerance);
    y.resize(4);
    y << 1, -0.3, 0.2, 0.7;
    return advance(flow, method, y, 20);
  };
  Eigen::VectorXd truth, end;
  end_of(false, 1e-14, truth);
  for (double tolerance : {1e-5, 1e-8, 1e-11}) {
    const int steps = end_of(true, tolerance, end);
    EXPECT_LT((end - truth).cwiseAbs().maxCoeff(), steps * tolerance) << tolerance;  // one per step at most
  }
}

TEST(Extrapolation, ParallelStepIsShortenedWhenTheFunctionFails) {
  SpringsInLanes flow;
  Eigen::VectorXd y(4), dy(4), out(4);
  y << 2.9, 0, 2, 0;
  flow.derivative(0, y, dy);
  const Attempt attempt = Extrapolation(1e-6).attempt(flow, 0, 1, y, dy, out);
  EXPECT_FALSE(attempt.evaluated);
  EXPECT_DOUBLE_EQ(attempt.next_step, 0.25);
}

}  // namespace
}  // namespace borelli::test
