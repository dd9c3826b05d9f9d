#include "dynamics/formats/model_write.hpp"

#include <fmt/core.h>

#include "dynamics/formats/scene_file.hpp"

namespace borelli {

Result<WrittenModel> write_model(const Scene& scene, const std::filesystem::path& path,
                                 const ModelExtras& extras) {
  const std::string ending = path.extension().string();
  if (ending == ".xml" || ending == ".mjcf") return write_mjcf(scene, extras);
  if (ending == ".urdf") return write_urdf(scene, extras);
  if (ending == ".osim") return write_osim(scene, extras);
  if (ending != ".toml")
    return bad_use(path.string(),
                   fmt::format("{}; expected {}", ending.empty() ? "has no ending" : "has an unknown ending",
                               model_endings));
  auto text = write_scene(scene);
  if (!text) return tl::unexpected(text.error());
  std::string comments;
  for (const std::string& line : extras.comments) comments += "# " + line + "\n";
  return WrittenModel{comments + *text, {}};
}

}  // namespace borelli
