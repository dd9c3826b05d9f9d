// The coefficients of embedded pairs against the order conditions of all rooted trees; orders, error control
// and dense output on problems with closed solutions.
#include "dynamics/methods/embedded_runge_kutta.hpp"

#include <fmt/format.h>

#include <cmath>

#include "functions.hpp"
#include "rooted_trees.hpp"

namespace borelli::test {
namespace {

TEST(RootedTrees, CountsMatchTheLiterature) {  // Hairer, Norsett, Wanner, table II.2.3
  EXPECT_EQ(rooted_trees(4).size(), 8u);
  EXPECT_EQ(rooted_trees(8).size(), 200u);
}

/// The coupling matrix of all stages: of the step, of its end and of the dense output.
Eigen::MatrixXd coupling_of(const EmbeddedTableau& tableau) {
  const int all = tableau.all_stages(), stages = tableau.step.stages;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(all, all);
  for (int i = 0; i < stages; ++i) {
    for (int j = 0; j < stages; ++j) A(i, j) = tableau.step.coupling[i * stages + j];
    A(stages, i) = tableau.step.weights[i];
  }
  for (int i = 0; i < tableau.dense_stages; ++i)
    for (int j = 0; j < all; ++j) A(stages + 1 + i, j) = tableau.dense_coupling[i * all + j];
  return A;
}

Eigen::VectorXd padded(std::span<const double> numbers, int size) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size);
  for (std::size_t i = 0; i < numbers.size(); ++i) out[Eigen::Index(i)] = numbers[i];
  return out;
}

/// The dense output's weights at theta, of all stages.
Eigen::VectorXd dense_weights(const EmbeddedTableau& tableau, double theta) {
  const int all = tableau.all_stages(), stages = tableau.step.stages;
  const Eigen::VectorXd b = padded(tableau.step.weights, all);
  const Eigen::VectorXd first = Eigen::VectorXd::Unit(all, 0), end = Eigen::VectorXd::Unit(all, stages);
  std::vector<Eigen::VectorXd> terms{b, first - b, b - end - (first - b)};
  for (std::size_t i = 0; i < tableau.dense_weights.size(); i += all)
    terms.push_back(padded(tableau.dense_weights.subspan(i, all), all));
  Eigen::VectorXd out = Eigen::VectorXd::Zero(all);
  double factor = 1;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    factor *= i % 2 == 0 ? theta : 1 - theta;
    out += factor * terms[i];
  }
  return out;
}

struct Pair {
  const char* name;
  const EmbeddedTableau& tableau;
  int error_order, coarse_order;  // of the embedded results
  double rounding;                // rounding of sums of the coefficients: their size times 1e-16
};
const Pair pairs[] = {{"dopri5", dormand_prince_5(), 4, 0, 1e-14},
                      {"dop853", dormand_prince_853(), 5, 3, 1e-13}};

TEST(EmbeddedRungeKutta, CoefficientsMeetTheOrderConditions) {
  for (const Pair& pair : pairs) {
    const EmbeddedTableau& tableau = pair.tableau;
    const int all = tableau.all_stages(), order = tableau.step.order;
    const Eigen::MatrixXd A = coupling_of(tableau);
    const Eigen::VectorXd b = padded(tableau.step.weights, all);
    EXPECT_LT(order_violation(A, b, order), pair.rounding) << pair.name;
    EXPECT_GT(order_violation(A, b, order + 1), 1e-6) << pair.name;
    const Eigen::VectorXd embedded = b - padded(tableau.error, all);
    EXPECT_LT(order_violation(A, embedded, pair.error_order), pair.rounding) << pair.name;
    EXPECT_GT(order_violation(A, embedded, pair.error_order + 1), 1e-6) << pair.name;
    if (!tableau.coarse_error.empty()) {
      const Eigen::VectorXd coarse = b - padded(tableau.coarse_error, all);
      EXPECT_LT(order_violation(A, coarse, pair.coarse_order), pair.rounding) << pair.name;
      EXPECT_GT(order_violation(A, coarse, pair.coarse_order + 1), 1e-6) << pair.name;
    }
    // the stages' times are the sums of their rows
    const Eigen::VectorXd sums = A.rowwise().sum();
    for (int i = 0; i < tableau.step.stages; ++i)
      EXPECT_NEAR(sums[i], tableau.step.nodes[i], 1e-14) << pair.name;
    for (int i = 0; i < tableau.dense_stages; ++i)
      EXPECT_NEAR(sums[tableau.step.stages + 1 + i], tableau.dense_nodes[i], 1e-14) << pair.name;
    for (double theta : {0.1, 0.37, 0.5, 0.81, 1.0})
      EXPECT_LT(order_violation(A, dense_weights(tableau, theta), tableau.dense_order, theta),
                10 * pair.rounding)
          << pair.name << " at " << theta;
    EXPECT_GT(order_violation(A, dense_weights(tableau, 0.37), tableau.dense_order + 1, 0.37), 1e-7)
        << pair.name;
  }
}

// Euler's equations of a free solid with moments 1, 2, 3: smooth, nonlinear, three components.
FunctionFlow euler_top() {
  return {3, [](double, const Eigen::VectorXd& w, Eigen::VectorXd& dw) {
            dw << -w[1] * w[2], w[2] * w[0], -w[0] * w[1] / 3;
          }};
}

TEST(EmbeddedRungeKutta, DenseOutputHasItsOrder) {
  for (const Pair& pair : pairs) {
    // largest difference within one step of h from many small ones
    const auto error = [&](double h) {
      FunctionFlow flow = euler_top();
      EmbeddedRungeKutta method(pair.tableau, 1e9);
      const Eigen::VectorXd y = Eigen::Vector3d(0.3, 1, 0.9);
      Eigen::VectorXd dy(3), out(3), between(3);
      flow.derivative(0, y, dy);
      EXPECT_TRUE(method.attempt(flow, 0, h, y, dy, out).accepted);
      EXPECT_TRUE(method.prepare_dense(flow, 0, h, y, dy, out));
      double worst = 0;
      for (double theta : {0.15, 0.3, 0.45, 0.6, 0.75, 0.9}) {
        EmbeddedRungeKutta fine(dormand_prince_853(), 1e9);
        method.interpolate(theta, between);
        worst = std::max(worst, (between - integrate(flow, fine, y, theta * h, 40)).norm());
      }
      method.interpolate(1, between);
      EXPECT_LT((between - out).norm(), 1e-15);
      method.interpolate(0, between);
      EXPECT_LT((between - y).norm(), 1e-15);
      return worst;
    };
    // steps at which the next order's term is small
    const double h = pair.tableau.dense_order < 5 ? 0.1 : 0.6;
    EXPECT_NEAR(std::log2(error(h) / error(h / 2)), pair.tableau.dense_order + 1, 0.3) << pair.name;
  }
}

TEST(EmbeddedRungeKutta, ErrorEstimateControlsTheStep) {
  for (const Pair& pair : pairs) {
    FunctionFlow flow = euler_top();
    EmbeddedRungeKutta method(pair.tableau, 1e-9), fine(dormand_prince_853(), 1e9);
    Eigen::VectorXd y = Eigen::Vector3d(0.3, 1, 0.9), dy(3), out(3);
    flow.derivative(0, y, dy);
    double h = 3;
    Attempt attempt = method.attempt(flow, 0, h, y, dy, out);
    EXPECT_FALSE(attempt.accepted) << pair.name;
    EXPECT_GE(attempt.worst, 0);
    for (int i = 0; i < 10 && !attempt.accepted; ++i)
      attempt = method.attempt(flow, 0, h = attempt.next_step, y, dy, out);
    ASSERT_TRUE(attempt.accepted) << pair.name;
    EXPECT_LT((out - integrate(flow, fine, y, h, 40)).norm(), 1e-9) << pair.name;
    EXPECT_LE(attempt.next_step, h) << pair.name;  // no growth right after a rejection
  }
}

TEST(EmbeddedRungeKutta, FirstStepMeetsTheTolerance) {
  for (const Pair& pair : pairs)
    for (const double rate : {0.1, 1., 30.})
      for (double tolerance = 1e-3; tolerance > 1e-11; tolerance /= 10) {
        SCOPED_TRACE(fmt::format("{} at {:g}, rate {:g}", pair.name, tolerance, rate));
        FunctionFlow turning(2, [&](double, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
          dy << rate * y[1], -rate * y[0];
        });
        EmbeddedRungeKutta method(pair.tableau, tolerance);
        const Eigen::Vector2d start(0.6, 0.8);
        Eigen::VectorXd dy(2), out(2);
        turning.derivative(0, start, dy);
        turning.evaluations = 0;
        const double h = method.first_step(turning, 0, start, dy);
        EXPECT_EQ(turning.evaluations, 1);
        ASSERT_GT(h, 0);
        EXPECT_TRUE(method.attempt(turning, 0, h, start, dy, out).accepted);
        const double c = std::cos(rate * h), s = std::sin(rate * h);
        const Eigen::Vector2d exact(c * start[0] + s * start[1], c * start[1] - s * start[0]);
        EXPECT_LE((out - exact).lpNorm<Eigen::Infinity>(), tolerance);
        EXPECT_FALSE(method.attempt(turning, 0, 20 * h, start, dy, out).accepted);
      }
  FunctionFlow resting(1, [](double, const Eigen::VectorXd&, Eigen::VectorXd&) {});
  EmbeddedRungeKutta method(dormand_prince_853(), 1e-6);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(1);
  EXPECT_EQ(method.first_step(resting, 0, zero, zero), 0);
}

TEST(EmbeddedRungeKutta, CountsItsEvaluations) {
  for (const auto& [tableau, step, dense] :
       {std::tuple(&dormand_prince_5(), 6, 0), {&dormand_prince_853(), 11, 4}}) {
    FunctionFlow flow = euler_top();
    EmbeddedRungeKutta method(*tableau, 1);
    const Eigen::VectorXd y = Eigen::Vector3d(0.3, 1, 0.9);
    Eigen::VectorXd dy(3), out(3);
    flow.derivative(0, y, dy);
    flow.evaluations = 0;
    method.attempt(flow, 0, 0.1, y, dy, out);
    EXPECT_EQ(flow.evaluations, step);
    method.prepare_dense(flow, 0, 0.1, y, dy, out);
    EXPECT_EQ(flow.evaluations, step + dense);
  }
}

}  // namespace
}  // namespace borelli::test
