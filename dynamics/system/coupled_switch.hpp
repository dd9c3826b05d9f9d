// Switches whose coordinate is a function of another one, as compile() takes them.
#pragma once

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// The scene with each Coupled switch made free, starting where its function says, and a
/// `coordinate_function` that holds it there. Fails with its place: a ball, a start of its own, another
/// coordinate that is not there, is no scalar, or comes back to this one.
Result<Scene> without_coupled_switches(const Scene& scene);

}  // namespace borelli
