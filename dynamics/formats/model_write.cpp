#include "dynamics/formats/model_write.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "dynamics/formats/scene_file.hpp"
#include "error/file_ending.hpp"

namespace borelli {
namespace {

Result<WrittenModel> write_toml(const Scene& scene, const ModelExtras& extras) {
  auto text = write_scene(scene);
  if (!text) return tl::unexpected(text.error());
  std::string comments;
  for (std::string line : extras.comments) {
    std::replace(line.begin(), line.end(), '\n', ' ');
    comments += "# " + line + "\n";
  }
  return WrittenModel{comments + *text, {}};
}

struct ModelFormat {
  std::string_view ending;
  Result<WrittenModel> (*write)(const Scene&, const ModelExtras&);
};

constexpr std::array<ModelFormat, 5> model_formats{{{".xml", write_mjcf},
                                                    {".mjcf", write_mjcf},
                                                    {".urdf", write_urdf},
                                                    {".osim", write_osim},
                                                    {".toml", write_toml}}};

const ModelFormat* format_of(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  const auto found = std::find_if(model_formats.begin(), model_formats.end(),
                                  [&](const ModelFormat& format) { return format.ending == ending; });
  return found == model_formats.end() ? nullptr : &*found;
}

}  // namespace

Result<void> check_model_ending(const std::filesystem::path& path) {
  if (format_of(path)) return {};
  const std::string ending = ending_of(path);
  return bad_use(path.string(),
                 fmt::format("{}; expected .xml or .mjcf (MuJoCo), .urdf (ROS), .osim (OpenSim) or .toml",
                             ending.empty() ? "has no ending" : fmt::format("has the ending {}", ending)));
}

Result<WrittenModel> write_model(const Scene& scene, const std::filesystem::path& path,
                                 const ModelExtras& extras) {
  if (auto fine = check_model_ending(path); !fine) return tl::unexpected(fine.error());
  return format_of(path)->write(scene, extras);
}

}  // namespace borelli
