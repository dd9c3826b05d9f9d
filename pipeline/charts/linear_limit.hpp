// Largest stable step of a fixed-step method for small deviations from a scene's start, by linear theory. It
// is drawn beside the measured limit.
#pragma once

#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// Linearisation of d/dt (x, v) = (v, a(x, v)) at the start, with its velocities taken as constant.
struct SmallDeviations {
  std::vector<std::complex<double>> eigenvalues;  ///< 1/s
  bool by_velocity = false;  ///< accelerations depend on velocities: damped, or gyroscopic
};

/// From the exact derivatives of the accelerations (derivatives.hpp), constraints included. Empty if these do
/// not exist (contacts, a singular start).
std::optional<SmallDeviations> deviations_from_start(const System& system);

/// Growth rate of small deviations of the motion itself: the largest real part of the eigenvalues, 1/s; 0 if
/// rounding could explain it.
double growth_rate(const SmallDeviations& deviations);

/// The largest step h at which the method's response to exp(lambda t) does not grow, for every eigenvalue
/// lambda of a motion that does not grow by itself. Condition: |R(h lambda)| <= 1 with the method's stability
/// polynomial R (euler, rk2, rk4: Hairer and Wanner, Solving ODEs II, IV.2), or h |lambda| <= 2 if
/// accelerations depend on positions alone (semi_implicit_euler, verlet: Hairer, Lubich, Wanner, Geometric
/// numerical integration, I.5). Infinite for A-stable methods (implicit_midpoint, gauss4, gauss6,
/// generalized_alpha); empty if theory gives no number.
std::optional<double> linear_limit(const std::string& method, const SmallDeviations& deviations);

}  // namespace borelli
