// Where the markers of a scene are during its motion.
#pragma once

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/recordings/marker_motion.hpp"

namespace borelli {

/// World places of the scene's markers. `motion` gives times, solids and poses; its other members may be
/// empty. Errors: a scene without markers; a marker on a solid that the motion does not have.
Result<MarkerMotion> marker_paths(const Scene& scene, const Trajectory& motion);

}  // namespace borelli
