// The step up to which a method of fixed steps is stable on small deviations from the start of a scene: what
// theory says, to draw beside what runs show.
#pragma once

#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// d/dt (x, v) = (v, a(x, v)) at the start, its velocities taken as steady.
struct SmallDeviations {
  std::vector<std::complex<double>> eigenvalues;  ///< 1/s
  bool by_velocity = false;  ///< accelerations depend on velocities: damped, or gyroscopic
};

/// By the exact derivatives of the accelerations (derivatives.hpp), constraints included. Nothing where these
/// cannot be had (contacts, a singular start).
std::optional<SmallDeviations> deviations_from_start(const System& system);

/// The rate at which small deviations grow by themselves: the largest real part of the eigenvalues, 1/s,
/// where rounding does not make it.
double growth_rate(const SmallDeviations& deviations);

/// The largest step h for which the method keeps exp(lambda t) from growing for all eigenvalues, those of
/// motions that grow by themselves left out: |R(h lambda)| <= 1 with the method's stability polynomial
/// (euler, rk2, rk4: Hairer and Wanner, Solving ODEs II, IV.2), or h |lambda| <= 2 where accelerations depend
/// on positions alone (semi_implicit_euler, verlet: Hairer, Lubich, Wanner, Geometric numerical integration,
/// I.5). Infinite where nothing bounds it (A-stable: implicit_midpoint, gauss4, gauss6, generalized_alpha);
/// nothing where theory has no such number.
std::optional<double> linear_limit(const std::string& method, const SmallDeviations& deviations);

}  // namespace borelli
