#include "pipeline/stages/run_inputs.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "pipeline/files/digest.hpp"
#include "process/input_file.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/dicom_segmentation.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

// a volume's own file or folder, and the other files that hold its voxels
Result<std::vector<std::string>> files_of_volume(const std::string& path) {
  std::error_code problem;
  if (fs::is_directory(path, problem) || is_dicom_file(path)) return std::vector{path};
  const auto header = read_image_header(path);
  if (!header) return tl::unexpected(header.error());
  std::vector<std::string> files{header->header_file};
  for (const VoxelFile& file : header->voxel_files())
    if (file.path != header->header_file) files.push_back(file.path);
  return files;
}

}  // namespace

bool is_captured(const RunInput& input) {
  constexpr std::array roles{"motion", "forces", "static_trial", "marker_map"};
  return std::ranges::find(roles, input.role) != roles.end();
}

Result<std::vector<RunInput>> inputs_of(const RunSettings& settings) {
  std::vector<RunInput> inputs;
  for (const auto& [role, path] : {std::pair{"volume", settings.volume}, {"labels", settings.labels}}) {
    if (path.empty()) continue;
    auto files = files_of_volume(path);
    if (!files) return tl::unexpected(files.error());
    inputs.push_back({role, std::move(*files)});
  }
  std::error_code problem;
  std::string names = settings.label_names;
  if (!settings.labels.empty() && names.empty() && fs::exists(names_file(settings.labels), problem))
    names = names_file(settings.labels);
  if (!names.empty()) inputs.push_back({"label_names", {names}});
  const auto& ready = ready_mappings;
  if (!settings.label_mapping.empty() && std::ranges::find(ready, settings.label_mapping) == std::end(ready))
    inputs.push_back({"label_mapping", {settings.label_mapping}});
  if (!settings.landmarks.empty()) inputs.push_back({"landmarks", {settings.landmarks}});
  const CapturedSettings& captured = settings.captured;
  for (const auto& [role, path] : {std::pair{"motion", captured.motion},
                                   {"forces", captured.forces},
                                   {"static_trial", captured.trial},
                                   {"marker_map", captured.marker_map}})
    if (!path.empty()) inputs.push_back({role, {path}});
  for (const RunInput& input : inputs)
    for (const std::string& file : input.files)
      if (!fs::is_directory(file, problem))
        if (auto fine = check_input_file(file); !fine) return tl::unexpected(fine.error());
  return inputs;
}

InputNames input_names(const RunSettings& s) {
  return {s.keep_paths,
          {s.volume, s.labels, s.label_names, s.label_mapping, s.landmarks, s.captured.motion,
           s.captured.forces, s.captured.trial, s.captured.marker_map}};
}

Result<nlohmann::json> digests_of(const std::vector<RunInput>& inputs, const InputNames& names) {
  auto digests = nlohmann::json::object();
  for (const RunInput& input : inputs)
    for (const std::string& file : input.files) {
      const auto digest = digest_of(file);
      if (!digest) return tl::unexpected(digest.error());
      digests[input.role].push_back({{"file", names.name_of(file)}, {"sha256", *digest}});
    }
  return digests;
}

}  // namespace borelli
