// Derivatives of the dynamics at one state, for users and other programs; at many states:
// state_derivatives.hpp. Exact to rounding.
//
// Directions. By q: nv columns in the tangent space of the positions, in the units of the velocities: a
// scalar coordinate itself (m or rad), or for a ball a small rotation x in its own axes (rad), q exp(x). By v
// and by efforts: nv columns each. By inertia: ten columns per body of `inertials`, see inertial_numbers.
#pragma once

#include "dynamics/equations/evaluate.hpp"

namespace borelli {

/// Meaning of a body's ten columns: mass (kg), gravity centre (m) and tensor about the gravity centre (kg
/// m^2), in the axes of the frame after its last switch. Solids welded together are one body. A product of
/// inertia stands in the tensor twice; both entries vary together.
inline constexpr const char* inertial_numbers[10] = {"mass", "centre.x", "centre.y", "centre.z", "xx",
                                                     "yy",   "zz",       "xy",       "xz",       "yz"};

/// Derivatives of the accelerations a and multipliers lambda that `evaluate` gives.
struct ForwardDerivatives {
  /// Rows: coordinates, as in Evaluation::coordinates.
  Rows acceleration_by_q, acceleration_by_v, acceleration_by_efforts;  ///< nv x nv
  Rows acceleration_by_inertia;                                        ///< nv x 10 inertials.size()
  /// Rows: constraint rows. For dependent rows, derivatives of the least multipliers with the same effect.
  Rows multipliers_by_q, multipliers_by_v, multipliers_by_efforts;  ///< rows x nv
  Rows multipliers_by_inertia;                                      ///< rows x 10 inertials.size()
  std::vector<std::string> inertials;  ///< bodies with mass, each named after its first solid
};

/// At the given state (not assembled), with generalised forces `efforts` (nv, or empty) added, for the
/// scene's own parameters. Fails where `evaluate` does.
Result<ForwardDerivatives> forward_derivatives(const System& system, const State& state,
                                               const Eigen::VectorXd& efforts = Eigen::VectorXd());

/// Inverse dynamics without constraints: the generalised forces that accelerations need beyond the scene's
/// own, tau = A a + B - Q (nv, N or N m), and their derivatives.
struct InverseDynamics {
  Eigen::VectorXd efforts;                        ///< tau
  Rows efforts_by_q, efforts_by_v, efforts_by_a;  ///< nv x nv; the last is A
  Rows efforts_by_inertia;                        ///< nv x 10 inertials.size()
  std::vector<std::string> inertials;             ///< as above
};

/// At a state and accelerations a (nv). Fails if either does not fit the system.
Result<InverseDynamics> inverse_dynamics(const System& system, const State& state, const Eigen::VectorXd& a);

}  // namespace borelli
