// Replaces coupled switches by free ones with constraints, for compile().
#pragma once

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// The scene with each Coupled switch made free, starting at the value of its function, and a
/// `coordinate_function` that enforces it. Errors, with the place of the switch: a ball, a start of its own,
/// and another coordinate that does not exist, is not scalar, or is coupled back to this one.
Result<Scene> without_coupled_switches(const Scene& scene);

}  // namespace borelli
