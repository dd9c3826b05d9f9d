// Derivatives of the dynamics, exact to rounding: the engine's own formulas on dual numbers (dual.hpp) give
// those of the residuals
//   r = A a + B - Q - L^T lambda,   c = L a + E
// at fixed a and lambda; where the accelerations are what is asked for, the implicit function theorem gives
//   [A -L^T; L 0] [da; dlambda] = -[dr; dc],
// solved with the factors that the accelerations themselves were found with. (For the unconstrained case see
// Carpentier, Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.)
//
// Directions. By q: the tangent of the positions, nv columns, in the units of the velocities: a scalar
// coordinate itself (m or rad), of a ball the small turn in its own axes (rad), q exp(x). By v and by
// efforts: nv columns each. By inertia: ten columns per body of `inertials`, see inertial_numbers.
#pragma once

#include "dynamics/equations/evaluate.hpp"

namespace borelli {

/// What the ten columns of a body stand for: its mass (kg), its gravity centre (m) and its tensor about the
/// gravity centre (kg m^2), in the axes of the frame that its last switch leads to. Solids welded together
/// are one body. A product of inertia stands in the tensor twice, and both move.
inline constexpr const char* inertial_numbers[10] = {"mass", "centre.x", "centre.y", "centre.z", "xx",
                                                     "yy",   "zz",       "xy",       "xz",       "yz"};

/// Of the accelerations a and the multipliers lambda that `evaluate` gives, the motion's only free
/// quantities.
struct ForwardDerivatives {
  /// Rows: coordinates, as in Evaluation::coordinates.
  Rows acceleration_by_q, acceleration_by_v, acceleration_by_efforts;  ///< nv x nv
  Rows acceleration_by_inertia;                                        ///< nv x 10 inertials.size()
  /// Rows: constraint rows. Where rows depend on others, of the least multipliers that do the same.
  Rows multipliers_by_q, multipliers_by_v, multipliers_by_efforts;  ///< rows x nv
  Rows multipliers_by_inertia;                                      ///< rows x 10 inertials.size()
  std::vector<std::string> inertials;  ///< the bodies that have mass, each by the name of its first solid
};

/// At a state as it is, with `efforts` (nv, or empty) added, by the scene's own numbers. Fails where
/// `evaluate` does.
Result<ForwardDerivatives> forward_derivatives(const System& system, const State& state,
                                               const Eigen::VectorXd& efforts = Eigen::VectorXd());

/// How the residual r changes with q at fixed v, a (nv) and lambda (rows): nv x nv. Fails where the state
/// does not fit the system; what the user's functions throw goes through.
Result<Rows> residual_by_q(const System& system, const State& state, const Eigen::VectorXd& a,
                           const Eigen::VectorXd& multipliers);

/// The generalized efforts that accelerations ask for beside the scene's own, without its constraints:
/// tau = A a + B - Q (nv numbers, N or N m), and their derivatives.
struct InverseDynamics {
  Eigen::VectorXd efforts;                        ///< tau
  Rows efforts_by_q, efforts_by_v, efforts_by_a;  ///< nv x nv; the last is A
  Rows efforts_by_inertia;                        ///< nv x 10 inertials.size()
  std::vector<std::string> inertials;             ///< as above
};

/// At a state and accelerations a (nv).
Result<InverseDynamics> inverse_dynamics(const System& system, const State& state, const Eigen::VectorXd& a);

}  // namespace borelli
