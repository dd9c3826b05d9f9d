// Inertias of models whose authors gave some links none, or any numbers, because nothing moves by them: what
// is fixed to the world, or to a body that has mass enough.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// Locks free coordinates at their initial values: each of these names, or all that begin with it and a dot
/// (a joint's of several coordinates). Errors: no such free coordinate.
Result<void> lock_coordinates(Scene& scene, const std::vector<std::string>& names);

/// What settle_inertias changed, for people, a line each.
struct SettledInertias {
  std::vector<std::string> motion;  ///< what changes the motion
  std::vector<std::string> other;
};

/// Solids that only fixed and locked switches join are one body, and the body's inertia must be possible
/// (check_physical), not each solid's:
/// - of a body fixed to the world, impossible inertias are dropped;
/// - in a body that moves, with an impossible one among them, its solids' inertias become one, of the solid
///   nearest to the root;
/// - a body that moves and weighs less than `minimum_mass` (kg) becomes a ball of water of that mass (its
///   centre stays);
/// - free coordinates that move no mass are locked, and what couples them to others is dropped; but not one
///   that others with mass follow.
/// Errors, with `where` the solid's name: the moving body of that solid is impossible.
Result<SettledInertias> settle_inertias(Scene& scene, double minimum_mass);

}  // namespace borelli
