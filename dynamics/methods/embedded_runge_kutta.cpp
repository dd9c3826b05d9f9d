#include "dynamics/methods/embedded_runge_kutta.hpp"

#include "dynamics/methods/slope_jacobian.hpp"
#include "dynamics/numbers/exceeds.hpp"

namespace borelli {

namespace {

/// The power of h in the estimated error.
int error_power(const EmbeddedTableau& tableau) {
  // The damped estimate of orders 5 and 3 goes as h^8 (section II.10 of the book), that of a 5(4) pair as
  // h^5.
  return tableau.step.order;
}

// Slopes whose relative difference is smaller differ only by rounding.
constexpr double same_slopes = 1e-12;

/// Euclidean distance of two vectors over `count` components from `first`, each relative to its scale.
double distance(const Eigen::VectorXd& scale, const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                Eigen::Index first, Eigen::Index count) {
  return (a.segment(first, count) - b.segment(first, count))
      .cwiseQuotient(scale.segment(first, count))
      .norm();
}

double size(const Eigen::VectorXd& scale, const Eigen::VectorXd& a, Eigen::Index first, Eigen::Index count) {
  return a.segment(first, count).cwiseQuotient(scale.segment(first, count)).norm();
}

}  // namespace

EmbeddedRungeKutta::EmbeddedRungeKutta(const EmbeddedTableau& tableau, double tolerance)
    : tableau_(tableau),
      tolerance_(tolerance),
      control_(error_power(tableau), tableau.limits),
      k_(tableau.all_stages()),
      dense_(4 + tableau.dense_weights.size() / tableau.all_stages()) {}

/// The slope at a stage that uses the first `stages` slopes.
bool EmbeddedRungeKutta::evaluate(Flow& flow, double t, double h, const Eigen::VectorXd& y, double node,
                                  const double* coupling, int stages, Eigen::VectorXd& slope) {
  stage_ = y;
  for (int j = 0; j < stages; ++j)
    if (coupling[j] != 0) stage_ += h * coupling[j] * k_[j];
  return flow.derivative(t + node * h, stage_, slope);
}

Attempt EmbeddedRungeKutta::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                    const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  const Attempt failed{.evaluated = false, .accepted = false, .next_step = 0.25 * h};
  const Tableau& step = tableau_.step;
  const int stages = step.stages;
  test_stiffness(flow, dy);
  k_[0] = dy;
  for (int i = 1; i < stages; ++i)
    if (!evaluate(flow, t, h, y, step.nodes[i], &step.coupling[i * stages], i, k_[i])) return failed;
  out = y;
  for (int i = 0; i < stages; ++i)
    if (step.weights[i] != 0) out += h * step.weights[i] * k_[i];
  end_known_ = tableau_.error[stages] != 0;
  if (end_known_ && !flow.derivative(t + h, out, k_[stages])) return failed;

  Attempt attempt;
  const double error = error_of(flow.error_scale(), h, attempt.worst) / tolerance_;
  if (!std::isfinite(error)) return failed;
  attempt.accepted = error <= 1;
  if (attempt.accepted) {  // the last stage, still in stage_, also lies at the step's end
    last_known_ = true;
    last_step_ = h;
    last_slope_ = k_[stages - 1];
    last_gap_ = distance(flow.error_scale(), out, stage_, 0, acting_components(flow));
  }
  attempt.next_step =
      attempt.accepted ? control_.after_accepted(h, error) : control_.after_rejected(h, error);
  return attempt;
}

/// Estimates the first step from the size of the slope and its rate of change: for motion with `speed` and
/// `rate`, the p-th derivative is about speed rate^(p-1), and the error is taken as 100 times that. After
/// Hairer, Norsett, Wanner, Solving ODEs I, section II.4, whose estimate depends on the unit of time. The
/// step moves no component by more than its scale.
double EmbeddedRungeKutta::first_step(Flow& flow, double t, const Eigen::VectorXd& y,
                                      const Eigen::VectorXd& dy) {
  const auto largest = [&](const Eigen::VectorXd& of) {
    return of.cwiseQuotient(flow.error_scale()).lpNorm<Eigen::Infinity>();
  };
  const double speed = largest(dy);
  if (!(speed > 0)) return 0;
  const double whole = 1 / speed, little = 0.01 * whole;
  stage_ = y + little * dy;
  if (!flow.derivative(t + little, stage_, k_[0])) return 0;
  const double rate = largest(k_[0] - dy) / (little * speed);
  const double h = std::pow(0.01 * tolerance_ * rate / speed, 1. / error_power(tableau_)) / rate;
  return std::isfinite(h) ? std::min(h, whole) : whole;
}

/// The last stage of a step and its result are two states at the same time. The difference of their slopes
/// estimates the largest eigenvalue. The scene is stiff after fifteen steps at the stability limit, unless
/// six other steps come between (Hairer and Wanner, Solving ODEs II, section IV.2). If y holds positions,
/// only the velocities' slopes are compared, because the slopes of positions belong to the local coordinates
/// of their own step.
void EmbeddedRungeKutta::test_stiffness(const Flow& flow, const Eigen::VectorXd& dy) {
  if (!last_known_) return;
  last_known_ = false;
  const Eigen::VectorXd& scale = flow.error_scale();
  const Eigen::Index first = flow.positions(), count = acting_components(flow) - first;
  const double change = distance(scale, dy, last_slope_, first, count);
  if (last_gap_ <= 0 || change <= same_slopes * size(scale, dy, first, count)) return;
  if (last_step_ * change / last_gap_ > tableau_.stability) {
    other_steps_ = 0;
    if (++stiff_steps_ == 15) stiff_ = true;
  } else if (++other_steps_ == 6) {
    stiff_steps_ = 0;
  }
}

void EmbeddedRungeKutta::reset() {
  control_.reset();
  last_known_ = false;
}

double EmbeddedRungeKutta::error_of(const Eigen::VectorXd& scale, double h, int& worst) const {
  const auto weighted = [&](std::span<const double> weights, Eigen::Index i) {
    double sum = 0;
    for (int j = 0; j <= tableau_.step.stages; ++j)
      if (weights[j] != 0) sum += weights[j] * k_[j][i];
    return std::abs(h * sum) / scale[i];
  };
  double error = 0, coarse = 0;
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    const double part = weighted(tableau_.error, i);
    if (exceeds(part, error)) {
      error = part;
      worst = int(i);
    }
    if (!tableau_.coarse_error.empty()) coarse = std::max(coarse, weighted(tableau_.coarse_error, i));
  }
  if (tableau_.coarse_error.empty() || error == 0) return error;
  return error * error / std::sqrt(error * error + 0.01 * coarse * coarse);
}

bool EmbeddedRungeKutta::prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                       const Eigen::VectorXd& dy, const Eigen::VectorXd& out) {
  const int stages = tableau_.step.stages, all = tableau_.all_stages();
  if (!end_known_ && !flow.derivative(t + h, out, k_[stages])) return false;
  end_known_ = true;
  for (int i = 0; i < tableau_.dense_stages; ++i)
    if (const int k = stages + 1 + i;
        !evaluate(flow, t, h, y, tableau_.dense_nodes[i], &tableau_.dense_coupling[i * all], k, k_[k]))
      return false;
  dense_step_ = h;
  dense_[0] = y;
  dense_[1] = out - y;
  dense_[2] = h * dy - dense_[1];
  dense_[3] = dense_[1] - h * k_[stages] - dense_[2];
  for (std::size_t term = 4; term < dense_.size(); ++term) {
    dense_[term].setZero(y.size());
    for (int j = 0; j < all; ++j)
      if (const double d = tableau_.dense_weights[(term - 4) * all + j]; d != 0)
        dense_[term] += h * d * k_[j];
  }
  return true;
}

/// y + theta (r1 + (1 - theta) (r2 + theta (r3 + (1 - theta) (r4 + ...)))).
void EmbeddedRungeKutta::interpolate(double theta, Eigen::VectorXd& y) const {
  y = dense_.back();
  for (std::size_t term = dense_.size() - 1; term-- > 0;) {
    y *= term % 2 == 0 ? theta : 1 - theta;
    y += dense_[term];
  }
}

}  // namespace borelli
