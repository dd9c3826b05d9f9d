// Markers of a sample walk: a common set over the landmarks of a scanned body.
#pragma once

#include <map>
#include <string>

#include "dynamics/scene/scene.hpp"
#include "dynamics/scene/site.hpp"
#include "error/error.hpp"
#include "pipeline/body/foot_soles.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Places by marker name, of those whose landmark and segment are there, and one on each thigh and shank:
/// halfway between its joint centres and 6 cm (shank: 5 cm) in front. `body`: at its start in the pose of the
/// landmarks. Errors: as compile.
Result<std::map<std::string, SolidPoint>> walk_markers(const Scene& body, const Landmarks& landmarks);

/// Points of the floor z = 0 below heel, metatarsal heads I and V and toe tip of a body that stands on it.
FootSoles standing_soles(const Landmarks& landmarks);

}  // namespace borelli
