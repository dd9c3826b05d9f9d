// Writes scenes as models of other programs: MJCF (MuJoCo), URDF (ROS), OpenSim.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// A file of triangles that shows a solid, with the axes of the solid's frame.
struct ModelMesh {
  std::string solid;
  std::string file;            ///< as the model refers to it: relative to the model's folder, or absolute
  double metres_per_unit = 1;  ///< size of the file's unit
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the file's origin in the solid, m
};

/// A named frame of a solid, such as its anatomical axes.
struct ModelFrame {
  std::string solid, name;
  Pose pose;  ///< in the solid
};

/// Contents of a model file besides its scene.
struct ModelExtras {
  std::vector<ModelMesh> meshes;
  std::vector<ModelFrame> frames;
  std::vector<std::string> comments;  ///< provenance and deviations, one line each
};

/// The text of a model, and what its format cannot hold.
struct WrittenModel {
  std::string text;
  std::vector<std::string> omissions;  ///< one sentence each, by name
};

/// A scene as MJCF: read_model() restores the same mechanics. Errors name the solid that MJCF cannot hold.
Result<WrittenModel> write_mjcf(const Scene& scene, const ModelExtras& extras = {});
/// A scene as URDF.
Result<WrittenModel> write_urdf(const Scene& scene, const ModelExtras& extras = {});
/// A scene as a model of OpenSim (layout of version 4).
Result<WrittenModel> write_osim(const Scene& scene, const ModelExtras& extras = {});

/// Refuses a file whose ending names none of the formats of write_model().
Result<void> check_model_ending(const std::filesystem::path& path);

/// A scene in the format that the ending of `path` asks for: .xml or .mjcf, .urdf, .osim, or .toml, which
/// holds all. Errors: another ending; a scene that does not compile, or that the format cannot hold.
Result<WrittenModel> write_model(const Scene& scene, const std::filesystem::path& path,
                                 const ModelExtras& extras = {});

}  // namespace borelli
