#include "dynamics/constraints/equilibrium.hpp"

#include <fmt/format.h>

#include <Eigen/QR>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/constraints/change_in_time.hpp"
#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/equations/state_derivatives.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double balanced = 1e-10;  // of the largest force; above the rounding of sums of a hundred terms
constexpr double met = 1e-12;       // in parts of a row's length
constexpr int most_iterations = 300, most_pushes = 20;
constexpr double push_size = 0.3;  // rad, or parts of a coordinate's length

/// Residuals at given positions and their derivatives, both without units: generalised forces times the
/// coordinate's length over the largest such product, rows over their length.
class Balance {
 public:
  Balance(const System& system, State state)
      : system_(system),
        w_(system),
        derivatives_(system),
        state_(std::move(state)),
        coordinate_scale_(Eigen::Map<const VectorXd>(system.velocity_scale.data(), system.nv)),
        row_scale_(Eigen::Map<const VectorXd>(system.row_scale.data(), system.rows)) {}

  Result<void> look() {
    // A singular mass matrix does not matter here: rows, Q and kinematics are known all the same.
    const Fault fault =
        update_terms(system_, system_.parameters, state_.t, state_.q.data(), state_.v.data(), w_);
    if (fault && fault.kind != Fault::Kind::singular_mass)
      return tl::unexpected(describe(system_, fault, state_.t));
    return {};
  }

  /// The multipliers that balance the generalised forces best (least squares).
  VectorXd first_multipliers() const {
    if (system_.rows == 0) return VectorXd();
    const MatrixXd Lt = coordinate_scale_.asDiagonal() * w_.rows.L.leftCols(system_.nv).transpose();
    return Lt.completeOrthogonalDecomposition().solve(-(coordinate_scale_.cwiseProduct(efforts())));
  }

  /// The largest sum over a coordinate of |Q| and all |L^T lambda| terms, times its length, J.
  double largest(const VectorXd& multipliers) const {
    double out = 0;
    for (int i = 0; i < system_.nv; ++i) {
      double sum = std::abs(w_.terms.Q[i]);
      for (int r = 0; r < system_.rows; ++r) sum += std::abs(w_.rows.L(r, i) * multipliers[r]);
      out = std::max(out, coordinate_scale_[i] * sum);
    }
    return out;
  }

  VectorXd residual(const VectorXd& multipliers, double unit) const {
    VectorXd out(system_.nv + system_.rows);
    VectorXd r = -efforts();
    if (system_.rows > 0) r -= w_.rows.L.leftCols(system_.nv).transpose() * multipliers;
    out.head(system_.nv) = coordinate_scale_.cwiseProduct(r) / unit;
    out.tail(system_.rows) = w_.rows.h.cwiseQuotient(row_scale_);
    return out;
  }

  /// Derivative of the residual by the positions, rows and columns times the coordinates' lengths, J.
  MatrixXd stiffness(const VectorXd& multipliers) {
    const VectorXd at_rest = VectorXd::Zero(system_.nv);
    find_residual_derivatives(system_, system_.parameters, state_.t, state_.q.data(), state_.v.data(),
                              at_rest.data(), multipliers, derivatives_);
    return coordinate_scale_.asDiagonal() * derivatives_.by_q() * coordinate_scale_.asDiagonal();
  }

  /// Jacobian of residual(), by positions in units of their lengths and multipliers in `unit` over row
  /// lengths.
  MatrixXd slope(const MatrixXd& stiffness, double unit) const {
    const int n = system_.nv, m = system_.rows;
    MatrixXd J = MatrixXd::Zero(n + m, n + m);
    J.topLeftCorner(n, n) = stiffness / unit;
    if (m > 0) {
      const MatrixXd L =
          row_scale_.cwiseInverse().asDiagonal() * w_.rows.L.leftCols(n) * coordinate_scale_.asDiagonal();
      J.bottomLeftCorner(m, n) = L;
      J.topRightCorner(n, m) = -L.transpose();
    }
    return J;
  }

  /// Applies a step given without units.
  void move(const VectorXd& step, double unit, VectorXd& multipliers) {
    const VectorXd x = coordinate_scale_.cwiseProduct(step.head(system_.nv));
    from_local_coordinates(system_, state_.q.data(), x.data(), state_.q.data());
    if (system_.rows > 0) multipliers += unit * step.tail(system_.rows).cwiseQuotient(row_scale_);
  }

  /// Error that names the coordinate or constraint farthest from balance.
  Error complaint(const VectorXd& residual, double unit) const {
    Eigen::Index worst = 0;
    residual.cwiseAbs().maxCoeff(&worst);
    if (worst >= system_.nv)
      return {fmt::format("constraint '{}'", system_.row_names[std::size_t(worst - system_.nv)]),
              fmt::format("no equilibrium was found: at the best balance of efforts its residual is {:.3g}",
                          std::abs(residual[worst]) * row_scale_[worst - system_.nv])};
    return {
        fmt::format("coordinate '{}'", system_.velocity_name(int(worst))),
        fmt::format(
            "no equilibrium was found: at the best balance of efforts {:.3g} (N or N m) remains unbalanced",
            std::abs(residual[worst]) * unit / coordinate_scale_[worst])};
  }

  const State& state() const { return state_; }
  void set(const VectorXd& q) { state_.q = q; }
  const ConstraintRows& rows() const { return w_.rows; }

 private:
  VectorXd efforts() const { return w_.terms.Q.head(system_.nv); }

  const System& system_;
  Workspace w_;
  StateDerivatives derivatives_;
  State state_;
  VectorXd coordinate_scale_, row_scale_;
};

Result<void> check_still(const System& system, const ConstraintRows& rows, double t) {
  for (std::size_t d = 0; d < system.parameters.drives.size(); ++d)
    for (const TimeFunction& f : system.parameters.drives[d].functions) {
      const TimeValue now = at(f, t);
      if (now.rate != 0 || now.acceleration != 0)
        return bad_use(fmt::format("driven coordinate '{}'", system.driven[d].name),
                       fmt::format("moves at t = {:g} s, so nothing is at rest; drive it by a constant, lock "
                                   "it, or choose another time",
                                   t));
    }
  for (int r = 0; r < system.rows; ++r)
    if (rows.partial_rate[r] != 0)
      return bad_use(fmt::format("constraint '{}'", system.row_names[std::size_t(r)]),
                     fmt::format("moves at t = {:g} s, so nothing is at rest; choose another time", t));
  return {};
}

/// Levenberg and Marquardt's method on the residuals of Balance.
class BalanceSearch {
 public:
  BalanceSearch(const System& system, const State& assembled)
      : system_(system), balance_(system, assembled) {}

  /// Sets positions, multipliers, iterations and imbalance of `out`.
  Result<void> run(Equilibrium& out) {
    if (auto done = balance_.look(); !done) return done;
    if (auto still = check_still(system_, balance_.rows(), balance_.state().t); !still) return still;
    multipliers_ = balance_.first_multipliers();
    if (auto found = iterate(out); !found) return found;
    out.state.q = balance_.state().q;
    out.multipliers = multipliers_;
    return {};
  }

 private:
  Result<void> iterate(Equilibrium& out) {
    for (; out.iterations < most_iterations; ++out.iterations) {
      const MatrixXd stiffness = balance_.stiffness(multipliers_);
      // The unit is the largest generalised force, or the stiffness times a move by one length if that is
      // larger.
      unit_ = std::max(balance_.largest(multipliers_), stiffness.cwiseAbs().maxCoeff());
      if (unit_ == 0) unit_ = 1;  // no force acts
      const VectorXd r = balance_.residual(multipliers_, unit_);
      out.imbalance = r.head(system_.nv).cwiseAbs().maxCoeff();
      const double off = system_.rows > 0 ? r.tail(system_.rows).cwiseAbs().maxCoeff() : 0;
      if (out.imbalance <= balanced && off <= met) return {};
      const auto lowered = lower(balance_.slope(stiffness, unit_), r);
      if (!lowered) return tl::unexpected(lowered.error());
      if (*lowered) continue;
      // At a maximum of the imbalance no step lowers it.
      if (off <= met && out.imbalance > 100 * balanced && pushes_++ < most_pushes) {
        if (auto done = push(r); !done) return done;
        continue;
      }
      if (auto done = balance_.look(); !done) return done;
      // At the level of rounding no step lowers the residual.
      if (out.imbalance <= 100 * balanced && off <= 100 * met) return {};
      const Error why = balance_.complaint(r, unit_);
      return failure(why.where, why.what);
    }
    const Error why = balance_.complaint(balance_.residual(multipliers_, unit_), unit_);
    return failure(why.where, why.what + fmt::format(", after {} iterations", most_iterations));
  }

  /// Makes a step that lowers the residual r, whose Jacobian is J: the less it does, the more it is damped.
  /// False: no step does, and nothing has moved.
  Result<bool> lower(const MatrixXd& J, const VectorXd& r) {
    const Eigen::Index n = J.cols();
    MatrixXd damped(2 * n, n);
    VectorXd wanted = VectorXd::Zero(2 * n);
    damped.topRows(n) = J;
    wanted.head(n) = -r;
    const VectorXd q = balance_.state().q, before = multipliers_;
    for (int attempt = 0; attempt < 40; ++attempt) {
      damped.bottomRows(n) = std::sqrt(damping_) * MatrixXd::Identity(n, n);
      const VectorXd step = damped.colPivHouseholderQr().solve(wanted);
      if (step.head(system_.nv).cwiseAbs().maxCoeff() <= 1) {  // at most 1 rad or one coordinate length
        balance_.move(step, unit_, multipliers_);
        if (auto done = balance_.look(); !done) return tl::unexpected(done.error());
        if (balance_.residual(multipliers_, unit_).norm() < r.norm()) {
          damping_ = std::max(damping_ / 10, 1e-16);
          return true;
        }
      }
      balance_.set(q);
      multipliers_ = before;
      damping_ *= 10;
    }
    return false;
  }

  /// Moves along the unbalanced forces.
  Result<void> push(const VectorXd& r) {
    VectorXd step = VectorXd::Zero(r.size());
    step.head(system_.nv) = -r.head(system_.nv) * (push_size / r.head(system_.nv).cwiseAbs().maxCoeff());
    balance_.move(step, unit_, multipliers_);
    damping_ = 1e-3;
    return balance_.look();
  }

  const System& system_;
  Balance balance_;
  VectorXd multipliers_;
  double damping_ = 1e-3;
  double unit_ = 1;  // of forces, see Balance
  int pushes_ = 0;
};

/// The first later time at which the state is not at rest, in words.
std::string why_not_lasting(const System& system, const State& state) {
  constexpr double steady = 1e-6;  // of the accelerations that each generalised force gives alone
  const ChangeInTime change = change_in_time(system, state.t);
  for (const double t : change.times) {
    State later = state;
    later.t = t;
    const auto then = evaluate(system, later);
    if (!then) return fmt::format("{}: {}", change.words(), then.error().message());
    const VectorXd lengths = Eigen::Map<const VectorXd>(system.velocity_scale.data(), system.nv);
    const VectorXd gives = (then->generalized_efforts.cwiseAbs() + then->bias.cwiseAbs())
                               .cwiseQuotient(then->mass_matrix.diagonal());
    const double largest = gives.cwiseQuotient(lengths).maxCoeff(),
                 moves = then->acceleration.cwiseQuotient(lengths).cwiseAbs().maxCoeff();
    if (moves > steady * largest || !violation(system, *then).empty())
      return fmt::format("{}: at t = {:.6g} s the state is not at rest", change.words(), t);
  }
  return "";
}

Result<Equilibrium> balanced_state(const System& system, const State& start) {
  if (auto fits = check_state(system, start); !fits) return tl::unexpected(fits.error());
  if (!system.contacts.empty())
    return bad_use(
        fmt::format("constraint '{}'", system.constraint_names[std::size_t(system.contacts[0].constraint)]),
        "is a contact, which the search for an equilibrium cannot treat; replace it by a constraint or a "
        "limit_spring");
  if (system.nv == 0) return bad_use(system.scene, "has no free coordinate, so it is at rest anyway");
  // The search also stores derivatives, its Jacobian, and a damped copy with twice the rows.
  if (auto fits = admit_workspaces(system, system.settings.equations, 6, true); !fits)
    return tl::unexpected(fits.error());
  Equilibrium out;
  out.state = start;
  out.state.v.setZero();
  if (system.rows > 0)
    if (auto assembled = assemble(system, out.state); !assembled) return tl::unexpected(assembled.error());
  if (auto found = BalanceSearch(system, out.state).run(out); !found) return tl::unexpected(found.error());
  out.holds_at = why_not_lasting(system, out.state);
  return out;
}

}  // namespace

Result<Equilibrium> find_equilibrium(const System& system, const State& start) {
  return at_border(system, [&] { return balanced_state(system, start); });
}

}  // namespace borelli
