// Inertia of surfaces, for MJCF's shells (shellinertia="true", inertia="shell").
#pragma once

#include "dynamics/scene/shape.hpp"

namespace borelli {

/// Inertia of a surface with 1 kg/m^2, in the frame of the form. Closed forms; for an ellipsoid the numeric
/// integral over its surface, which MuJoCo approximates. A cone counts its base.
Inertial shell_inertial(const Form& form);

}  // namespace borelli
