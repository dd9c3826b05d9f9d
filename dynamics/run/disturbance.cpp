#include "dynamics/run/disturbance.hpp"

#include "dynamics/equations/equations.hpp"
#include "dynamics/run/contact_events.hpp"

namespace borelli {

namespace {

/// The active rows at the state, including those of closed contacts.
Eigen::MatrixXd rows_at(const System& system, const State& state) {
  Workspace workspace(system);
  ConstraintRows every(system);
  every.every_row = true;
  update_kinematics(system, system.parameters, state.t, state.q.data(), state.v.data(), workspace.kinematics);
  scan_constraints(system, system.parameters, workspace.kinematics, every);
  for (const Contact& contact : system.contacts)
    if (every.h[contact.row] > closed_gap * system.row_scale[contact.row])
      every.L.middleRows(contact.row, contact.tangents ? 3 : 1).setZero();
  return every.L.leftCols(system.nv);
}

}  // namespace

State disturbed(const System& system, const State& state, double part) {
  State out = state;
  const Eigen::Map<const Eigen::VectorXd> scale(system.velocity_scale.data(), system.nv);
  Eigen::VectorXd change(system.nv);  // in scales
  for (int i = 0; i < system.nv; ++i) change[i] = i % 2 == 0 ? part : -part;
  if (system.rows > 0) {
    const Eigen::MatrixXd rows = rows_at(system, state) * scale.asDiagonal();
    change -= rows.completeOrthogonalDecomposition().solve(rows * change);
  }
  out.v += scale.cwiseProduct(change);
  return out;
}

}  // namespace borelli
