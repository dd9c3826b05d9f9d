// The free joint of a solid, as a sequence of switches.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/switch.hpp"

namespace borelli {

/// Three translations along the parent's axes, then a ball; they start at the pose X_PS. Positions: x, y, z
/// (m) and the quaternion (w, x, y, z). Velocities: linear in the parent's axes (m/s), angular in the solid's
/// own (rad/s). The coordinates are named <name>.x, .y, .z and <name>.turn.
std::vector<Switch> free_joint(const std::string& name, const Pose& X_PS);

}  // namespace borelli
