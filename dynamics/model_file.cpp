#include "dynamics/model_file.hpp"

#include <fmt/core.h>

#include <exception>
#include <fstream>
#include <new>

#include "dynamics/mjcf.hpp"
#include "dynamics/scene_file.hpp"
#include "dynamics/urdf.hpp"
#include "dynamics/xml_element.hpp"

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

}  // namespace

Result<ModelFile> read_model(const std::filesystem::path& path, const ModelOptions& options) {
  const bool named_xml = path.extension() == ".xml" || path.extension() == ".urdf";
  if (std::error_code problem;
      !std::filesystem::is_regular_file(path, problem) || !(named_xml || is_xml(path))) {
    if (options.floating)
      return bad_use(path.string(), "is not URDF: only a URDF's root can be left floating");
    return read_scene(path).map([](Scene scene) { return ModelFile{std::move(scene), {}, {}}; });
  }
  try {
    XmlElement root = read_xml(path);
    if (root.name == "robot") return read_urdf(root, options);
    if (options.floating)
      return bad_use(path.string(), "is not URDF: only a URDF's root can be left floating");
    if (root.name == "mujoco") {
      auto model = read_mjcf(std::move(root));
      if (model.scene.solids.empty())
        return bad_use(path.string(), "holds no body, so there is nothing that could move");
      return model;
    }
    return bad_use(root.where(),
                   fmt::format("the root is <{}>, expected <mujoco> (MJCF) or <robot> (URDF)", root.name));
  } catch (const XmlRefusal& refusal) {
    return tl::unexpected(refusal.error);
  } catch (const std::bad_alloc&) {
    return failure(path.string(), "is larger than memory has room for");
  } catch (const std::exception& problem) {  // (of files that come and go while they are read)
    return failure(path.string(), fmt::format("cannot be read: {}", problem.what()));
  }
}

}  // namespace borelli
