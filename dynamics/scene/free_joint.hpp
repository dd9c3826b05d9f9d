// The freedom of a solid in space as a sequence of switches.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/switch.hpp"

namespace borelli {

/// Three translations along the parent's axes, then a ball, starting at the pose X_PS: positions x, y, z (m)
/// and the quaternion (w, x, y, z); velocities linear in the parent's axes, angular in the solid's own. Named
/// <name>.x, .y, .z and <name>.turn.
std::vector<Switch> free_joint(const std::string& name, const Pose& X_PS);

}  // namespace borelli
