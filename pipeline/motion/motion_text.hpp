// Motions of scenes as files of other programs, chosen by the file's ending.
#pragma once

#include <string>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"

namespace borelli {

/// Whether motion_text writes files of this name: .bvh or .trc, in small or capital letters.
bool is_motion_text(const std::string& file);

/// .bvh: a skeleton of the scene's solids (bvh_skeleton.hpp). .trc: its markers, mm, in the scene's axes
/// (marker_paths.hpp). Errors: theirs.
Result<std::string> motion_text(const Scene& scene, const Trajectory& motion, const std::string& file);

}  // namespace borelli
