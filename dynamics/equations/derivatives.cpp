#include "dynamics/equations/derivatives.hpp"

#include <fmt/format.h>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/equations/state_derivatives.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Derivatives of a body's wrench (moment, force; at its frame's origin) by its ten inertial numbers.
Eigen::Matrix<double, 6, 10> wrench_by_inertia(const Inertial& inertial, const Vector3d& gravity,
                                               const BodyMotion& m) {
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  const Vector3d d = m.g - m.X.p, g_vdot = m.vdot - gravity;
  const Vector3d w = m.X.R.transpose() * m.w, wdot = m.X.R.transpose() * m.wdot;  // in the body's axes
  Eigen::Matrix<double, 6, 10> out;
  out.col(0) << d.cross(g_vdot), g_vdot;
  for (int i = 0; i < 3; ++i) {
    const Vector3d e = m.X.R.col(i);
    const Vector3d f = inertial.mass * (m.wdot.cross(e) + m.w.cross(m.w.cross(e)));
    out.col(1 + i) << inertial.mass * e.cross(g_vdot) + d.cross(f), f;
  }
  for (int i = 0; i < 6; ++i) {
    Matrix3d unit = Matrix3d::Zero();
    unit(row[i], column[i]) = unit(column[i], row[i]) = 1;
    out.col(4 + i) << m.X.R * (unit * wdot + w.cross(unit * w)), Vector3d::Zero();
  }
  return out;
}

/// Derivatives of inverse dynamics by the inertial numbers of `bodies`: nv x ten columns per body, after
/// find_residual_derivatives.
Rows by_inertia(const System& system, const std::vector<int>& bodies, const StateDerivatives& d) {
  Rows out = Rows::Zero(system.nv, 10 * Eigen::Index(bodies.size()));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = system.bodies[bodies[i]];
    const BodyMotion& m = d.kinematics.bodies[bodies[i]];
    const auto wrenches =
        wrench_by_inertia(system.parameters.inertials[bodies[i]], system.parameters.gravity, m);
    const int* support = system.branches().support.data() + body.first_support;
    for (int s = 0; s < body.support_count; ++s) {
      const int u = support[s];
      if (u >= system.nv) continue;
      const Vector3d w = d.kinematics.angular(u);
      const Vector3d v = d.kinematics.linear(u) + w.cross(m.X.p - d.kinematics.origin(u));
      out.row(u).segment<10>(10 * Eigen::Index(i)) =
          w.transpose() * wrenches.topRows<3>() + v.transpose() * wrenches.bottomRows<3>();
    }
  }
  return out;
}

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
    if (w.has_rows()) {
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
    Workspace w(system);
    const auto now = evaluate(system, state, efforts, w);
    if (!now) return tl::unexpected(now.error());
    // evaluate may not have needed the factor of A
    if (const Fault fault =
            update_terms(system, system.parameters, state.t, state.q.data(), state.v.data(), w))
      return tl::unexpected(describe(system, fault, state.t));
    const int n = system.nv;
    const std::vector<int> bodies = massive_bodies(system);
    if (auto fits = admit_derivatives(system, bodies.size()); !fits) return tl::unexpected(fits.error());
    StateDerivatives d(system);
    if (const Fault fault = find_acceleration_derivatives(system, system.parameters, state.t, state.q.data(),
                                                          state.v.data(), w, d))
      return tl::unexpected(describe(system, fault, state.t));
    ForwardDerivatives out;
    out.inertials = names_of(system, bodies);
    out.acceleration_by_q = d.by_q();
    out.acceleration_by_v = d.by_v();
    out.multipliers_by_q = d.c_by_q();
    out.multipliers_by_v = d.c_by_v();
    out.acceleration_by_efforts = -Rows::Identity(n, n);  // dr by efforts: r contains -efforts
    out.multipliers_by_efforts = Rows::Zero(system.rows, n);
    out.acceleration_by_inertia = by_inertia(system, bodies, d);
    out.multipliers_by_inertia = Rows::Zero(system.rows, out.acceleration_by_inertia.cols());
    solve(system, w, out.acceleration_by_efforts, out.multipliers_by_efforts);
    solve(system, w, out.acceleration_by_inertia, out.multipliers_by_inertia);
    return out;
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
    StateDerivatives d(system);
    find_residual_derivatives(system, system.parameters, state.t, state.q.data(), state.v.data(), a.data(),
                              Eigen::VectorXd::Zero(system.rows), d);
    InverseDynamics out;
    out.inertials = names_of(system, bodies);
    out.efforts = d.inverse.needed;
    out.efforts_by_q = d.by_q();
    out.efforts_by_v = d.by_v();
    out.efforts_by_a = d.inverse.A.selfadjointView<Eigen::Lower>();
    out.efforts_by_inertia = by_inertia(system, bodies, d);
    return out;
  });
}

}  // namespace borelli
