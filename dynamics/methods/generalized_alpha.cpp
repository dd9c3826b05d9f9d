#include "dynamics/methods/generalized_alpha.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/methods/motion_flow.hpp"
#include "dynamics/methods/slope_jacobian.hpp"
#include "dynamics/numbers/elimination.hpp"
#include "dynamics/numbers/exceeds.hpp"
#include "dynamics/numbers/settling.hpp"

namespace borelli {

namespace {

constexpr const char* no_convergence =
    "the equations of an implicit step did not converge; take smaller steps";
constexpr const char* no_motion = "nothing is free to move; choose another method";

/// Whether the row is a tangential row of a contact: it constrains the sliding velocity, not a position.
bool is_slip(const System& system, int row) {
  return std::any_of(system.contacts.begin(), system.contacts.end(), [&](const Contact& contact) {
    return contact.tangents && (row == contact.row + 1 || row == contact.row + 2);
  });
}

}  // namespace

GeneralizedAlpha::GeneralizedAlpha(double spectral_radius)
    : mass_share_((2 * spectral_radius - 1) / (spectral_radius + 1)),
      force_share_(spectral_radius / (spectral_radius + 1)),
      gamma_(0.5 - mass_share_ + force_share_),
      beta_(0.25 * (gamma_ + 0.5) * (gamma_ + 0.5)),
      gain_((1 - force_share_) / (1 - mass_share_)) {}

/// Continues from the step that ended at t. A repeated step starts as before. Otherwise the method's
/// accelerations start as those of the equations of motion.
void GeneralizedAlpha::take_up(double t, double h, const Eigen::VectorXd& dy) {
  if (made_ && std::abs(t - end_) <= 1e-9 * std::abs(h)) {
    a0_ = a1_;
    w0_ = w1_;
    known_ = true;
  } else if (!(known_ && t == start_)) {
    a0_ = w0_ = dy.segment(n_, n_);
    known_ = true;
  }
  made_ = false;
  start_ = t;
}

const char* GeneralizedAlpha::objection(const System& system, ConstraintTreatment treatment) const {
  return treatment == ConstraintTreatment::projection && system.has_kinematic_rows()
             ? "corrects positions only, and drops to first order where constraints hold velocities alone; "
               "set constraints to baumgarte"
             : nullptr;
}

/// x and v at the step's end from the accelerations a1_.
void GeneralizedAlpha::place(double h, const Eigen::VectorXd& y, Eigen::VectorXd& out) const {
  out.head(n_) = y.head(n_) + h * y.segment(n_, n_) + h * h * ((0.5 - beta_) * a0_ + beta_ * a1_);
  out.segment(n_, n_) = y.segment(n_, n_) + h * ((1 - gamma_) * a0_ + gamma_ * a1_);
}

/// Collects the independent rows active at the state last evaluated; returns their number.
int GeneralizedAlpha::collect_rows(const MotionFlow& motion, double h) {
  if (!motion.projects()) return 0;
  const System& system = motion.system();
  const Workspace& w = motion.workspace();
  if (rows_.rows() == 0) {
    rows_ = response_ = through_ = RowsOf<double>::Zero(system.rows, n_);
    gram_ = RowsOf<double>::Zero(system.rows, system.rows);
    wanted_ = Eigen::VectorXd::Zero(system.rows);
  }
  const int count = w.solver.rank();
  for (int k = 0; k < count; ++k) {
    const int row = w.solver.order()[k];
    rows_.row(k) = w.rows.L.row(row).head(n_);
    response_.row(k) = rows_.row(k);
    solve_transposed(system, w.factor, response_.row(k).data());
    solve_lower(system, w.factor, response_.row(k).data());
    wanted_[k] = is_slip(system, row) ? -w.rows.rate[row] / (gamma_ * h) : -w.rows.h[row] / (beta_ * h * h);
  }
  return count;
}

/// Adds the effect of constraint forces to change_, so that L change_ = wanted_.
void GeneralizedAlpha::hold_rows(int count) {
  for (int k = 0; k < count; ++k) {
    if (newton_) {
      column_ = response_.row(k).transpose();
      residual_ = factors_.solve(column_);
      through_.row(k) = residual_.transpose();
    } else {
      through_.row(k) = response_.row(k);
    }
    wanted_[k] -= rows_.row(k).dot(change_);
  }
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < count; ++k) gram_(i, k) = rows_.row(i).dot(through_.row(k));
  eliminate(gram_, wanted_, count);
  for (int k = 0; k < count; ++k) change_ += wanted_[k] * through_.row(k).transpose();
}

/// Factors Newton's matrix 1 / gain - gamma h da/dv - beta h^2 da/dx, by differences at the state `out` with
/// slope slope_.
bool GeneralizedAlpha::factor(Flow& flow, double t, double h, const Eigen::VectorXd& out) {
  jacobian_.resize(2 * n_, 2 * n_);
  if (!slope_jacobian(flow, t + h, out, slope_, moved_, moved_slope_, jacobian_)) return false;
  matrix_ =
      -gamma_ * h * jacobian_.bottomRightCorner(n_, n_) - beta_ * h * h * jacobian_.bottomLeftCorner(n_, n_);
  matrix_.diagonal().array() += 1 / gain_;
  factors_.compute(matrix_);
  factored_step_ = h;
  return true;
}

/// Iterates a1_ until the step's end satisfies equations and constraints.
GeneralizedAlpha::Outcome GeneralizedAlpha::iterate(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                                    Eigen::VectorXd& out) {
  const Eigen::VectorXd& scale = flow.error_scale();
  for (Settling settling;;) {
    place(h, y, out);
    if (!flow.derivative(t + h, out, slope_)) return Outcome::not_evaluated;
    w1_ = ((1 - mass_share_) * a1_ + mass_share_ * a0_ - force_share_ * w0_) / (1 - force_share_);
    residual_ = slope_.segment(n_, n_) - w1_;
    if (newton_)
      change_ = factors_.solve(residual_);
    else
      change_ = gain_ * residual_;
    const int count = flow.motion() ? collect_rows(*flow.motion(), h) : 0;
    if (count > 0) hold_rows(count);
    a1_ += change_;
    double worst = 0;
    for (Eigen::Index i = 0; i < n_; ++i) {
      // Relative also to the summands. A position that is exact to rounding leaves the velocity uncertain by
      // that over h.
      const double gained = std::abs(h * a1_[i]);
      const double speed = scale[n_ + i] + gained + (count > 0 ? scale[i] / std::abs(h) : 0);
      const double part = std::max(gamma_ * std::abs(h * change_[i]) / speed,
                                   beta_ * h * h * std::abs(change_[i]) / (scale[i] + std::abs(h) * gained));
      if (exceeds(part, worst)) worst = part;
    }
    const auto verdict = settling.after(worst);
    if (verdict == Settling::Verdict::settled) break;
    if (verdict != Settling::Verdict::go_on) return Outcome::not_solved;
  }
  place(h, y, out);
  w1_ = ((1 - mass_share_) * a1_ + mass_share_ * a0_ - force_share_ * w0_) / (1 - force_share_);
  return Outcome::solved;
}

Attempt GeneralizedAlpha::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                  const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  Attempt failed{.evaluated = false, .next_step = h};
  n_ = flow.positions();
  if (n_ == 0) {
    failed.trouble = no_motion;
    return failed;
  }
  take_up(t, h, dy);
  out = y;
  const auto predict = [&] {  // keep the accelerations w of the equations constant
    a1_ = (w0_ - mass_share_ * a0_) / (1 - mass_share_);
  };
  predict();
  // The matrix serves many steps of equal length (to rounding, because a whole number is fitted between
  // outputs).
  bool fresh = false;
  if (newton_ && std::abs(factored_step_ - h) > 1e-6 * std::abs(h)) newton_ = false;
  Outcome outcome = iterate(flow, t, h, y, out);
  for (int tries = 0; outcome != Outcome::solved && tries < 2 && !fresh; ++tries) {
    predict();
    place(h, y, out);
    if (!flow.derivative(t + h, out, slope_)) return failed;
    if (!factor(flow, t, h, out)) return failed;
    newton_ = fresh = true;
    outcome = iterate(flow, t, h, y, out);
  }
  if (outcome != Outcome::solved) {
    if (outcome == Outcome::not_solved) failed.trouble = no_convergence;
    return failed;
  }
  const Eigen::Index rest = y.size() - 2 * n_;  // trapezoidal rule
  out.tail(rest) = y.tail(rest) + 0.5 * h * (dy.tail(rest) + slope_.tail(rest));
  made_ = true;
  end_ = t + h;
  return {.next_step = h};
}

}  // namespace borelli
