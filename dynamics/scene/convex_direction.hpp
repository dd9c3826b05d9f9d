// The direction in which two convex shapes are nearest, by FCL, the Flexible Collision Library (Pan, Chitta,
// Manocha, ICRA 2012), on the support functions of libccd (Fiser).
#pragma once

#include <optional>

#include "dynamics/scene/convex.hpp"

namespace borelli {

/// Unit vector, world axes, from shape b to shape a along which they are nearest, or overlap least (Gilbert,
/// Johnson and Keerthi's algorithm; van den Bergen's expanding polytope). It is that of slightly smaller
/// copies: shapes that touch then still have a direction. Exact, within 1e-6, only where the copies have the
/// same nearest parts. `X_a`, `X_b`: poses of the shapes' own frames. None if the library finds none, or
/// a shape is thinner than 1e-8 of the pair's reach, which exceeds 100 m.
std::optional<Eigen::Vector3d> direction_between(const Convex& a, const Pose& X_a, const Convex& b,
                                                 const Pose& X_b);

}  // namespace borelli
