#include "dynamics/methods/gauss_legendre.hpp"

#include <cmath>

#include "dynamics/methods/slope_jacobian.hpp"
#include "dynamics/numbers/exceeds.hpp"
#include "dynamics/numbers/settling.hpp"

namespace borelli {

GaussLegendre::GaussLegendre(int stages)
    : stages_(stages),
      nodes_(stages),
      weights_(stages),
      coupling_(stages, stages),
      moves_(stages),
      slopes_(stages) {
  const double r3 = std::sqrt(3.0), r15 = std::sqrt(15.0);
  if (stages == 1) {
    nodes_ << 0.5;
    weights_ << 1;
    coupling_ << 0.5;
  } else if (stages == 2) {
    nodes_ << 0.5 - r3 / 6, 0.5 + r3 / 6;
    weights_ << 0.5, 0.5;
    coupling_ << 0.25, 0.25 - r3 / 6, 0.25 + r3 / 6, 0.25;
  } else {
    nodes_ << 0.5 - r15 / 10, 0.5, 0.5 + r15 / 10;
    weights_ << 5.0 / 18, 4.0 / 9, 5.0 / 18;
    coupling_ << 5.0 / 36, 2.0 / 9 - r15 / 15, 5.0 / 36 - r15 / 30,  //
        5.0 / 36 + r15 / 24, 2.0 / 9, 5.0 / 36 - r15 / 24,           //
        5.0 / 36 + r15 / 30, 2.0 / 9 + r15 / 15, 5.0 / 36;
  }
}

/// The slopes at the stages y + moves_.
bool GaussLegendre::evaluate(Flow& flow, double t, double h, const Eigen::VectorXd& y) {
  for (int i = 0; i < stages_; ++i) {
    stage_ = y + moves_[i];
    if (!flow.derivative(t + nodes_[i] * h, stage_, slopes_[i])) return false;
  }
  return true;
}

void GaussLegendre::start_from(double h, const Eigen::VectorXd& dy) {
  for (int i = 0; i < stages_; ++i) moves_[i] = nodes_[i] * h * dy;
}

GaussLegendre::Outcome GaussLegendre::iterate(Flow& flow, double t, double h, const Eigen::VectorXd& y) {
  const Eigen::VectorXd& scale = flow.error_scale();
  for (Settling settling;;) {
    if (!evaluate(flow, t, h, y)) return Outcome::not_evaluated;
    double worst = 0;
    for (int i = 0; i < stages_; ++i) {
      changed_.setZero(y.size());
      for (int j = 0; j < stages_; ++j) changed_ += h * coupling_(i, j) * slopes_[j];
      for (Eigen::Index k = 0; k < y.size(); ++k)
        if (const double part = std::abs(changed_[k] - moves_[i][k]) / scale[k]; exceeds(part, worst))
          worst = part;
      moves_[i].swap(changed_);
    }
    const auto verdict = settling.after(worst);
    if (verdict == Settling::Verdict::settled) return Outcome::solved;
    if (verdict != Settling::Verdict::go_on) return Outcome::not_solved;
  }
}

/// Factors the matrix 1 - h A x J (Kronecker product) of the stage equations.
bool GaussLegendre::factor(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                           const Eigen::VectorXd& dy) {
  const Eigen::Index n = acting_components(flow);
  jacobian_.resize(n, n);
  if (!slope_jacobian(flow, t, y, dy, stage_, changed_, jacobian_)) return false;
  matrix_.setIdentity(stages_ * n, stages_ * n);
  for (int i = 0; i < stages_; ++i)
    for (int j = 0; j < stages_; ++j) matrix_.block(i * n, j * n, n, n) -= h * coupling_(i, j) * jacobian_;
  factors_.compute(matrix_);
  factored_step_ = h;
  return true;
}

GaussLegendre::Outcome GaussLegendre::solve_by_newton(Flow& flow, double t, double h,
                                                      const Eigen::VectorXd& y, const Eigen::VectorXd& dy) {
  const Eigen::VectorXd& scale = flow.error_scale();
  const Eigen::Index n = acting_components(flow);
  bool fresh = false;
  // Equal steps differ by rounding, because a whole number of them is fitted between outputs.
  if (std::abs(factored_step_ - h) > 1e-6 * h) {
    if (!factor(flow, t, h, y, dy)) return Outcome::not_evaluated;
    fresh = true;
  }
  for (int attempt = 0; attempt < 2; ++attempt) {
    for (auto& move : moves_) move.setZero(y.size());
    for (Settling settling;;) {
      if (!evaluate(flow, t, h, y)) break;
      residual_.resize(stages_ * n);
      for (int i = 0; i < stages_; ++i) {
        changed_.setZero(y.size());
        for (int j = 0; j < stages_; ++j) changed_ += h * coupling_(i, j) * slopes_[j];
        residual_.segment(i * n, n) = changed_.head(n) - moves_[i].head(n);
        moves_[i].tail(y.size() - n) = changed_.tail(y.size() - n);
      }
      residual_ = factors_.solve(residual_).eval();
      double worst = 0;
      for (int i = 0; i < stages_; ++i)
        for (Eigen::Index k = 0; k < n; ++k) {
          const double by = residual_[i * n + k];
          moves_[i][k] += by;
          if (const double part = std::abs(by) / scale[k]; exceeds(part, worst)) worst = part;
        }
      const auto verdict = settling.after(worst);
      if (verdict == Settling::Verdict::settled) {
        return evaluate(flow, t, h, y) ? Outcome::solved : Outcome::not_evaluated;
      }
      if (verdict == Settling::Verdict::failed || (verdict == Settling::Verdict::slow && !fresh)) break;
    }
    if (fresh) return Outcome::not_solved;
    if (!factor(flow, t, h, y, dy)) return Outcome::not_evaluated;
    fresh = true;
  }
  return Outcome::not_solved;
}

Attempt GaussLegendre::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                               const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  Outcome outcome = Outcome::not_solved;
  if (!newton_) {
    start_from(h, dy);
    outcome = iterate(flow, t, h, y);
  }
  if (outcome != Outcome::solved) {
    newton_ = true;
    outcome = solve_by_newton(flow, t, h, y, dy);
  }
  if (outcome != Outcome::solved)
    return {.evaluated = false,
            .next_step = h,
            .trouble = outcome == Outcome::not_evaluated
                           ? nullptr
                           : "the equations of an implicit step did not converge; take smaller steps"};
  out = y;
  for (int i = 0; i < stages_; ++i) out += h * weights_[i] * slopes_[i];
  return {.next_step = h};
}

}  // namespace borelli
