// Describes a scene or a trajectory for `borelli info`, as JSON and as text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "dynamics/formats/model_file.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {

/// Solids with parents, joints and masses; coordinates; efforts; constraints; settings. Errors: those of
/// reading and compiling the scene.
Result<nlohmann::json> scene_info(const Command& command, const std::string& path,
                                  const ModelOptions& options);
std::string scene_info_text(const nlohmann::json& info);

/// Scene, times, coordinates, solids, energies at start and end, certificate.
Result<nlohmann::json> trajectory_info(const std::string& path);
std::string trajectory_info_text(const nlohmann::json& info);

}  // namespace borelli
