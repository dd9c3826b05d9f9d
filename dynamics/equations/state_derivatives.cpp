#include "dynamics/equations/state_derivatives.hpp"

#include "dynamics/equations/branch_sparse.hpp"

namespace borelli {

StateDerivatives::StateDerivatives(const System& system)
    : inverse(system),
      c_by_state(Rows::Zero(system.rows, inverse.by_state.cols())),
      kinematics(system, Equations::recursive),
      efforts(system),
      rows(system),
      pattern(system),
      factor(Rows::Zero(system.nv, system.nv)),
      column(Eigen::VectorXd::Zero(system.nv)),
      correction(column),
      wanted(Eigen::VectorXd::Zero(system.rows)),
      multipliers(wanted) {
  if (!system.efforts.empty() || system.rows > 0) actions.emplace(system);
  if (actions) actions->add_pattern(pattern);
}

void find_residual_derivatives(const System& system, const Parameters& parameters, double t, const double* q,
                               const double* v, const double* a, const Eigen::VectorXd& multipliers,
                               StateDerivatives& out) {
  update_kinematics<double>(system, parameters, parameters.inertials, t, q, v, a, out.kinematics);
  if (out.actions) {
    out.inverse.by_state.setZero();
    scan_efforts(system, parameters, out.kinematics, out.efforts);
  }
  if (system.rows > 0) {
    out.rows.loads = {&multipliers, &out.efforts};
    scan_constraints(system, parameters, out.kinematics, out.rows);
    out.rows.loads = {};
  }
  find_inverse_derivatives(system, parameters, parameters.inertials, out.kinematics,
                           out.actions ? &out.efforts : nullptr, out.inverse);
  if (!out.actions) return;
  out.actions->subtract_efforts(parameters, out.kinematics, out.inverse);
  if (system.rows > 0)
    out.actions->subtract_constraints(parameters, out.kinematics, multipliers, out.inverse, out.c_by_state);
}

Fault find_acceleration_derivatives(const System& system, const Parameters& parameters, double t,
                                    const double* q, const double* v, Workspace& solved,
                                    StateDerivatives& out) {
  find_residual_derivatives(system, parameters, t, q, v, solved.a.data(), solved.multipliers, out);
  Rows& x = out.inverse.by_state;
  const bool constrained = solved.has_rows();  // (then A has its factor)
  if (!constrained)
    if (const int singular = factor_mass_matrix(system, out.inverse.A, out.factor); singular >= 0)
      return {Fault::Kind::singular_mass, singular};
  solve_pair(system, constrained ? solved.factor : out.factor, out.pattern, -1, x.data(), x.cols());
  if (!constrained) return {};
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    if (i % out.inverse.half >= system.nv) continue;
    out.column = x.col(i);
    out.wanted = -out.c_by_state.col(i);
    out.wanted.noalias() -= solved.rows.L.leftCols(system.nv) * out.column;
    solved.solver.correct(solved.factor, out.wanted, out.correction);
    solved.solver.multipliers(out.multipliers);
    x.col(i) = out.column + out.correction;
    out.c_by_state.col(i) = out.multipliers;
  }
  return {};
}

}  // namespace borelli
