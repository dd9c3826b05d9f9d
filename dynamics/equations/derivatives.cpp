#include "dynamics/equations/derivatives.hpp"

#include <fmt/format.h>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/numbers/dual.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

namespace {

using Directions = Eigen::VectorX<DualNumber>;
constexpr int width = int(std::tuple_size_v<decltype(DualNumber::d)>);

/// The residuals r (over the free coordinates) and c at fixed accelerations and multipliers, and their
/// derivatives, up to `width` directions at a time.
class Residuals {
 public:
  Residuals(const System& system, const State& state, const Eigen::VectorXd& a, const Eigen::VectorXd& lambda)
      : system_(system),
        state_(state),
        a_(a.cast<DualNumber>()),
        lambda_(lambda),
        kinematics_(system, Equations::recursive),
        efforts_(system),
        recursion_(system),
        terms_(system, false),
        rows_(system),
        inertials_(system.bodies.size()),
        r(system.nv),
        c(system.rows) {
    for (std::size_t b = 0; b < inertials_.size(); ++b) {
      const Inertial& given = system.parameters.inertials[b];
      inertials_[b] = {given.mass, given.centre.cast<DualNumber>(), given.tensor.cast<DualNumber>()};
    }
    rest();
  }

  /// Derivatives by q (out: nv columns in each).
  void by_q(Rows& dr, Rows& dc) {
    for (int first = 0; first < system_.nv; first += width) {
      for (const CoordinateInfo& info : system_.coordinates)
        for (int i = 0; i < info.v_size; ++i)
          if (const int at = info.v_index + i - first; at >= 0 && at < width) seed(info, i, at);
      collect(first, std::min(width, system_.nv - first), dr, dc);
    }
  }

  void by_v(Rows& dr, Rows& dc) {
    for (int first = 0; first < system_.nv; first += width) {
      const int count = std::min(width, system_.nv - first);
      for (int i = 0; i < count; ++i) v_[first + i].d[i] = 1;
      collect(first, count, dr, dc);
    }
  }

  /// Derivatives by the inertial numbers of a body (ten columns from `first` on).
  void by_inertia(int body, int first, Rows& dr, Rows& dc) {
    static_assert(width == 10);
    constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    const auto given = inertials_[body];
    inertials_[body].mass.d[0] = 1;
    for (int i = 0; i < 3; ++i) inertials_[body].centre[i].d[1 + i] = 1;
    for (int i = 0; i < 6; ++i) {
      inertials_[body].tensor(row[i], column[i]).d[4 + i] = 1;
      inertials_[body].tensor(column[i], row[i]).d[4 + i] = 1;
    }
    collect(first, width, dr, dc);
    inertials_[body] = given;
  }

 private:
  /// Resets q and v to zero derivatives.
  void rest() {
    q_ = state_.q.cast<DualNumber>();
    v_ = state_.v.cast<DualNumber>();
  }

  /// Makes direction `at` the i-th velocity of a coordinate.
  void seed(const CoordinateInfo& info, int i, int at) {
    if (info.q_size == 1) {
      q_[info.q_index].d[at] = 1;
      return;
    }
    Quaternion turn = Quaternion::Zero();  // d exp(x) / dx_i at x = 0
    turn[1 + i] = 0.5;
    const Quaternion rate = product(state_.q.segment<4>(info.q_index), turn);
    for (int k = 0; k < 4; ++k) q_[info.q_index + k].d[at] = rate[k];
  }

  void collect(int first, int count, Rows& dr, Rows& dc) {
    update();
    for (int d = 0; d < count; ++d) {
      for (int i = 0; i < system_.nv; ++i) dr(i, first + d) = r[i].d[d];
      for (int i = 0; i < system_.rows; ++i) dc(i, first + d) = c[i].d[d];
    }
    rest();
  }

  void update() {
    const Parameters& p = system_.parameters;
    update_kinematics(system_, p, inertials_, state_.t, q_.data(), v_.data(), a_.data(), kinematics_);
    if (!system_.efforts.empty()) scan_efforts(system_, p, kinematics_, efforts_);
    find_own_forces(system_, p, inertials_, kinematics_, efforts_, recursion_, terms_);
    find_efforts(system_, p, kinematics_, efforts_, recursion_, terms_);
    r = (terms_.B - terms_.Q).head(system_.nv);
    if (system_.rows == 0) return;
    scan_constraints(system_, p, kinematics_, rows_);
    for (int row = 0; row < system_.rows; ++row) {
      for (int i = 0; i < system_.nv; ++i) r[i] -= lambda_[row] * rows_.L(row, i);
      c[row] = rows_.E[row];  // includes L a, since the kinematics were given a
    }
  }

  const System& system_;
  const State& state_;
  Directions a_;
  Eigen::VectorXd lambda_;
  KinematicsOf<DualNumber> kinematics_;
  EffortSumsOf<DualNumber> efforts_;
  RecursionOf<DualNumber> recursion_;
  LagrangeTermsOf<DualNumber> terms_;
  ConstraintRowsOf<DualNumber> rows_;
  InertialsOf<DualNumber> inertials_;
  Directions q_, v_;

 public:
  Directions r, c;
};

std::vector<int> massive_bodies(const System& system) {
  std::vector<int> out;
  for (int b = 1; b < int(system.bodies.size()); ++b)
    if (system.bodies[b].massive) out.push_back(b);
  return out;
}

std::vector<std::string> names_of(const System& system, const std::vector<int>& bodies) {
  std::vector<std::string> out;
  for (int b : bodies) out.push_back(system.solids[system.bodies[b].solids[0]]);
  return out;
}

/// Replaces dr and dc by da and dlambda, column by column.
void solve(const System& system, Workspace& w, Rows& dr, Rows& dc) {
  for (Eigen::Index column = 0; column < dr.cols(); ++column) {
    w.a = -dr.col(column);
    solve_transposed(system, w.factor, w.a.data());
    solve_lower(system, w.factor, w.a.data());
    if (system.rows > 0) {
      w.wanted = -dc.col(column) - w.rows.L.leftCols(system.nv) * w.a;
      w.solver.correct(w.factor, w.wanted, w.correction);
      w.solver.multipliers(w.multipliers);
      w.a += w.correction;
      dc.col(column) = w.multipliers;
    }
    dr.col(column) = w.a;
  }
}

/// Asks for the memory of the derivatives by positions, velocities, efforts and `bodies` inertias.
Result<void> admit_derivatives(const System& system, std::size_t bodies) {
  const double n = system.nv + system.rows, by = 5.0 * system.nv + 10.0 * double(bodies);
  return admit_large(system, sizeof(double) * n * by,
                     [&] { return fmt::format("the derivatives of {} accelerations", system.nv); });
}

}  // namespace

Result<ForwardDerivatives> forward_derivatives(const System& system, const State& state,
                                               const Eigen::VectorXd& efforts) {
  return at_border(system, [&]() -> Result<ForwardDerivatives> {
    const auto now = evaluate(system, state, efforts);
    if (!now) return tl::unexpected(now.error());
    const int n = system.nv;
    const std::vector<int> bodies = massive_bodies(system);
    if (auto fits = admit_derivatives(system, bodies.size()); !fits) return tl::unexpected(fits.error());
    ForwardDerivatives out;
    out.inertials = names_of(system, bodies);
    out.acceleration_by_q = out.acceleration_by_v = Rows::Zero(n, n);
    out.multipliers_by_q = out.multipliers_by_v = out.multipliers_by_efforts = Rows::Zero(system.rows, n);
    out.acceleration_by_inertia = Rows::Zero(n, 10 * Eigen::Index(bodies.size()));
    out.multipliers_by_inertia = Rows::Zero(system.rows, 10 * Eigen::Index(bodies.size()));
    out.acceleration_by_efforts = -Rows::Identity(n, n);  // dr by efforts: r contains -efforts
    Residuals residuals(system, state, now->acceleration, now->multipliers);
    residuals.by_q(out.acceleration_by_q, out.multipliers_by_q);
    residuals.by_v(out.acceleration_by_v, out.multipliers_by_v);
    for (int i = 0; i < int(bodies.size()); ++i)
      residuals.by_inertia(bodies[i], 10 * i, out.acceleration_by_inertia, out.multipliers_by_inertia);
    Workspace w(system);
    if (const Fault fault =
            update_terms(system, system.parameters, state.t, state.q.data(), state.v.data(), w))
      return tl::unexpected(describe(system, fault, state.t));
    if (system.rows > 0) w.solver.prepare(w.rows.L, w.factor, true);
    solve(system, w, out.acceleration_by_q, out.multipliers_by_q);
    solve(system, w, out.acceleration_by_v, out.multipliers_by_v);
    solve(system, w, out.acceleration_by_efforts, out.multipliers_by_efforts);
    solve(system, w, out.acceleration_by_inertia, out.multipliers_by_inertia);
    return out;
  });
}

Result<Rows> residual_by_q(const System& system, const State& state, const Eigen::VectorXd& a,
                           const Eigen::VectorXd& multipliers) {
  if (auto fits = check_state(system, state); !fits) return tl::unexpected(fits.error());
  return at_border(system, [&]() -> Result<Rows> {
    if (auto fits = admit_derivatives(system, 0); !fits) return tl::unexpected(fits.error());
    Rows dr = Rows::Zero(system.nv, system.nv), dc = Rows::Zero(system.rows, system.nv);
    Residuals(system, state, a, multipliers).by_q(dr, dc);
    return dr;
  });
}

Result<InverseDynamics> inverse_dynamics(const System& system, const State& state, const Eigen::VectorXd& a) {
  return at_border(system, [&]() -> Result<InverseDynamics> {
    const int n = system.nv;
    if (a.size() != n)
      return bad_use("accelerations",
                     fmt::format("have {} entries; the scene has {} velocities", a.size(), n));
    if (!a.allFinite()) return bad_use("accelerations", "contain a number that is not finite");
    if (auto fits = check_state(system, state); !fits) return tl::unexpected(fits.error());
    const std::vector<int> bodies = massive_bodies(system);
    if (auto fits = admit_derivatives(system, bodies.size()); !fits) return tl::unexpected(fits.error());
    if (auto fits = admit_workspaces(system, system.settings.equations, 1, true); !fits)
      return tl::unexpected(fits.error());
    InverseDynamics out;
    out.inertials = names_of(system, bodies);
    out.efforts_by_q = out.efforts_by_v = Rows::Zero(n, n);
    out.efforts_by_inertia = Rows::Zero(n, 10 * Eigen::Index(bodies.size()));
    Rows none = Rows::Zero(system.rows, std::max<Eigen::Index>(n, out.efforts_by_inertia.cols()));
    Residuals residuals(system, state, a, Eigen::VectorXd::Zero(system.rows));
    residuals.by_q(out.efforts_by_q, none);
    residuals.by_v(out.efforts_by_v, none);
    for (int i = 0; i < int(bodies.size()); ++i)
      residuals.by_inertia(bodies[i], 10 * i, out.efforts_by_inertia, none);
    Workspace w(system);
    out.efforts.resize(n);
    inverse_dynamics(system, system.parameters, system.parameters.inertials, state.t, state.q.data(),
                     state.v.data(), a.data(), w.kinematics, w.efforts, w.articulation, out.efforts.data());
    if (const Fault fault =  // only A is needed, singular or not
        update_terms(system, system.parameters, state.t, state.q.data(), state.v.data(), w);
        fault.kind == Fault::Kind::no_memory)
      return tl::unexpected(describe(system, fault, state.t));
    out.efforts_by_a = w.terms.A.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
    return out;
  });
}

}  // namespace borelli
