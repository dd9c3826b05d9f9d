// Repairs missing and impossible inertias of links that do not move by themselves; authors often omit or
// invent these.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// Locks free coordinates at their initial values. A name means the coordinate, or all coordinates "name.*"
/// of a joint. Errors: no free coordinate of that name.
Result<void> lock_coordinates(Scene& scene, const std::vector<std::string>& names);

/// What settle_inertias() changed, one line each for the user.
struct SettledInertias {
  std::vector<std::string> motion;  ///< changes that affect the motion
  std::vector<std::string> other;
};

/// Solids joined only by fixed and locked switches form one body. The inertia of the body must be possible
/// (check_physical), not that of each solid:
/// - Body fixed to the world: impossible inertias are dropped.
/// - Moving body with an impossible inertia among them: the inertias of its solids become one, of the solid
///   nearest to the root.
/// - Moving body lighter than `minimum_mass` (kg): becomes a ball of water of that mass (its centre stays).
/// - Free coordinates that move no mass are locked, and their couplings to others dropped, unless coordinates
///   with mass follow them.
/// Errors: the inertia of a moving body is impossible; `where` is the name of the solid.
Result<SettledInertias> settle_inertias(Scene& scene, double minimum_mass);

}  // namespace borelli
