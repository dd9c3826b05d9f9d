// Reads scenes from files of any supported kind: this program's TOML, MJCF (MuJoCo), URDF (ROS) and
// OpenSim's models.
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
  /// URDF and OpenSim: moving bodies lighter than this (kg) become balls of water of this mass
  double minimum_mass = 0;
  std::vector<std::string> locked = {};  ///< free coordinates, or joints, that stay at their initial values
};

struct ModelFile {
  Scene scene;
  /// File content that the scene does not model: kinds of elements and attributes with their number and first
  /// place, and initial values that were moved. Empty for TOML, which is read whole or refused.
  NotModelled not_modelled;
  /// Pairs that may touch in the file but have no contact in the scene; judge_passing() checks a motion for
  /// them.
  TouchablePairs without_contact;
};

/// Reads a scene. The content gives the kind of file: XML with the root <mujoco> is MJCF (mjcf.hpp), with
/// <robot> URDF (urdf.hpp), with <OpenSimDocument> a model of OpenSim (osim.hpp); a file that is not XML is a
/// scene in TOML (scene_file.hpp). The coordinates, in the order of the solids, have the order and convention
/// of the file. Errors name file and line.
Result<ModelFile> read_model(const std::filesystem::path& path, const ModelOptions& options = {});

}  // namespace borelli
