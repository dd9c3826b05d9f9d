// Scenes from files of any kind that this program reads: its own TOML, and the models of others, MJCF
// (MuJoCo) and URDF (ROS).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/contacts/pass_through.hpp"
#include "dynamics/formats/unread.hpp"
#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

struct ModelOptions {
  bool floating = false;  ///< URDF: the root link moves freely instead of being fixed to the world
  /// URDF: bodies that move and weigh less (kg) are taken as balls of water of that mass
  double minimum_mass = 0;
  std::vector<std::string> locked = {};  ///< free coordinates, or joints, that stay where they start
};

struct ModelFile {
  Scene scene;
  /// What the file holds and the scene does not: kinds of elements and attributes with how often they stand
  /// there and where first, and starts that were moved. Empty for TOML, which is read whole or refused.
  NotModelled not_modelled;
  /// What the file lets touch and the scene has no contact for; judge_passing() looks at a motion of it.
  std::vector<TouchablePair> without_contact;
};

/// Reads a scene; the file's kind is told by its content: XML with the root <mujoco> is MJCF (mjcf.hpp),
/// <robot> URDF (urdf.hpp), what is not XML is a scene in TOML (scene_file.hpp). The scene's coordinates, in
/// the order of its solids, are those of the file in the file's order and convention. Errors name file and
/// line.
Result<ModelFile> read_model(const std::filesystem::path& path, const ModelOptions& options = {});

}  // namespace borelli
