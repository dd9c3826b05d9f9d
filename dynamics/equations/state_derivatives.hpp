// Derivatives of the dynamics by positions and velocities at many states, exact to rounding, in plain
// numbers. For other programs and single states: derivatives.hpp.
//
// Those of the residuals r = A a + B - Q - L^T lambda and c = L a + E at fixed a and lambda are recursive
// (inverse_derivatives.hpp, action_derivatives.hpp). For the accelerations the implicit function theorem
// gives
//   [A -L^T; L 0] [da; dlambda] = -[dr; dc],
// solved with the factors of the accelerations themselves.
#pragma once

#include "dynamics/equations/action_derivatives.hpp"
#include "dynamics/equations/equations.hpp"

namespace borelli {

/// Scratch and results for one System; one per thread. Nothing allocates after the constructor.
struct StateDerivatives {
  explicit StateDerivatives(const System& system);

  /// Of r: inverse.by_state and A. After find_acceleration_derivatives, by_state holds those of the
  /// accelerations.
  InverseDerivatives inverse;
  Rows c_by_state;  ///< of c, or of the multipliers: rows x the same columns

  auto by_q() const { return inverse.by_state.leftCols(inverse.A.rows()); }
  auto by_v() const { return inverse.by_state.middleCols(inverse.half, inverse.A.rows()); }
  auto c_by_q() const { return c_by_state.leftCols(inverse.A.rows()); }
  auto c_by_v() const { return c_by_state.middleCols(inverse.half, inverse.A.rows()); }

  Kinematics kinematics;  ///< at the accelerations a
  EffortSums efforts;
  std::optional<ActionDerivatives> actions;  ///< empty without efforts and constraints
  ConstraintRows rows;
  RowPattern pattern;                                       ///< of by_state
  Rows factor;                                              ///< of A
  Eigen::VectorXd column, correction, wanted, multipliers;  ///< scratch
};

/// Derivatives of r (and r at zero multipliers, in inverse.needed) and c at time t, positions q (nq),
/// velocities v (nv), accelerations a (nv) and multipliers (rows). Contacts count as open.
void find_residual_derivatives(const System& system, const Parameters& parameters, double t, const double* q,
                               const double* v, const double* a, const Eigen::VectorXd& multipliers,
                               StateDerivatives& out);

/// Derivatives of the accelerations and multipliers that accelerate() has just found in `solved` at the same
/// state, with no active contact. Fails as factor_mass_matrix does.
Fault find_acceleration_derivatives(const System& system, const Parameters& parameters, double t,
                                    const double* q, const double* v, Workspace& solved,
                                    StateDerivatives& out);

}  // namespace borelli
