#include "dynamics/formats/model_file.hpp"

#include <fmt/core.h>

#include <exception>
#include <fstream>
#include <new>

#include "dynamics/formats/mjcf.hpp"
#include "dynamics/formats/osim.hpp"
#include "dynamics/formats/placeholder_inertia.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/formats/urdf.hpp"
#include "dynamics/formats/xml_element.hpp"
#include "error/file_ending.hpp"

namespace borelli {
namespace {

// XML begins with '<', after white space and perhaps a byte order mark.
bool is_xml(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  for (int c = file.get(); c != EOF; c = file.get()) {
    if (c == '<') return true;
    if (c != ' ' && c != '\t' && c != '\r' && c != '\n' && c != 0xEF && c != 0xBB && c != 0xBF) return false;
  }
  return false;
}

// Refuses options that only URDF has.
Result<void> check_not_floating(const std::filesystem::path& path, const ModelOptions& options) {
  if (options.floating)
    return bad_use(path.string(), "is not URDF; --floating applies only to the root of a URDF");
  return {};
}

// Refuses options that only URDF and OpenSim's models have.
Result<void> check_no_urdf_options(const std::filesystem::path& path, const ModelOptions& options) {
  if (auto fine = check_not_floating(path, options); !fine) return fine;
  if (options.minimum_mass > 0)
    return bad_use(path.string(), "is not URDF; --minimum-mass applies only to URDF and OpenSim models");
  return {};
}

Result<ModelFile> with_locks(ModelFile model, const std::filesystem::path& path,
                             const ModelOptions& options) {
  if (auto done = lock_coordinates(model.scene, options.locked); !done)
    return bad_use(path.string(), done.error().message());
  return model;
}

}  // namespace

Result<ModelFile> read_model(const std::filesystem::path& path, const ModelOptions& options) {
  const std::string ending = ending_of(path);
  const bool named_xml = ending == ".xml" || ending == ".urdf" || ending == ".osim";
  if (std::error_code problem;
      !std::filesystem::is_regular_file(path, problem) || !(named_xml || is_xml(path))) {
    if (auto fine = check_no_urdf_options(path, options); !fine) return tl::unexpected(fine.error());
    auto scene = read_scene(path);
    if (!scene) return tl::unexpected(scene.error());
    return with_locks(ModelFile{std::move(*scene), {}, {}}, path, options);
  }
  try {
    XmlElement root = read_xml(path);
    if (root.name == "robot") return read_urdf(root, options);
    if (root.name == "OpenSimDocument") {
      if (auto fine = check_not_floating(path, options); !fine) return tl::unexpected(fine.error());
      return with_locks(read_osim(root, options.minimum_mass), path, options);
    }
    if (auto fine = check_no_urdf_options(path, options); !fine) return tl::unexpected(fine.error());
    if (root.name == "mujoco") {
      auto model = read_mjcf(std::move(root));
      if (model.scene.solids.empty()) return bad_use(path.string(), "contains no body, so nothing can move");
      return with_locks(std::move(model), path, options);
    }
    return bad_use(root.where(), fmt::format("the root is <{}>, expected <mujoco> (MJCF), <robot> (URDF) or "
                                             "<OpenSimDocument> (OpenSim)",
                                             root.name));
  } catch (const XmlRefusal& refusal) {
    return tl::unexpected(refusal.error);
  } catch (const std::bad_alloc&) {
    return failure(path.string(), "does not fit into memory");
  } catch (const std::exception& problem) {  // (e.g. a file that vanishes while it is read)
    return failure(path.string(), fmt::format("cannot be read: {}", problem.what()));
  }
}

}  // namespace borelli
