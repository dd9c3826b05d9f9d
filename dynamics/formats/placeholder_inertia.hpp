// Mends missing and impossible inertias of links that do not move by themselves: authors often leave such
// inertias out or fill in any numbers.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// Locks free coordinates at their initial values. A name stands for the coordinate, or for all coordinates
/// "name.*" of a joint. Errors: no such free coordinate.
Result<void> lock_coordinates(Scene& scene, const std::vector<std::string>& names);

/// What settle_inertias() changed, one line each for the user.
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
