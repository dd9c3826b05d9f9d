#include "pipeline/verbs/volume_info.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <numbers>

#include "error/file_ending.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/files/volume_formats.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

// The patient direction of an axis: "Left", or "Left, 12.5 degrees off"
std::string direction(const Vector3d& axis) {
  static constexpr std::array<std::array<const char*, 2>, 3> names{
      {{"Left", "Right"}, {"Posterior", "Anterior"}, {"Superior", "Inferior"}}};
  Eigen::Index main = 0;
  const double cosine = axis.normalized().cwiseAbs().maxCoeff(&main);
  const std::string name = names[static_cast<std::size_t>(main)][axis[main] < 0];
  const double off = std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi;
  return off < 0.05 ? name : fmt::format("{}, {:.1f} degrees off", name, off);
}

json three(const Vector3d& v) { return {v[0], v[1], v[2]}; }

json grid_info(const Grid& grid) {
  json info;
  info["voxels"] = grid.size;
  info["spacing_mm"] = three(grid.spacing());
  for (int c = 0; c < 3; ++c) info["axes_run_to"].push_back(direction(grid.axes.col(c)));
  info["origin_mm_lps"] = three(grid.origin);
  info["sheared"] = shear(grid) > 1e-4;  // smaller shears are float32 rounding in headers
  return info;
}

// voxels and volume of each label, with its name if a table of names lies beside the map
Result<json> label_info(const Command& command, const std::string& path) {
  const auto map = read_labels(command, path);
  if (!map) return tl::unexpected(map.error());
  std::array<std::size_t, 256> counts{};
  for (const auto label : map->voxels) ++counts[label];
  json labels = json::array();
  for (std::size_t label = 1; label < map->names.size(); ++label) {
    if (counts[label] == 0) continue;
    labels.push_back({{"label", label},
                      {"name", map->names[label]},
                      {"voxels", counts[label]},
                      {"volume_ml", static_cast<double>(counts[label]) * map->grid.voxel_volume() * 1e-3}});
  }
  return labels;
}

Result<json> without_quantity(const Command& command, const std::string& path, const Error& reason) {
  const auto header = read_image_header(path);
  if (std::error_code problem; !header || !std::filesystem::exists(header->data_file, problem))
    return tl::unexpected(reason);
  json info = grid_info(header->grid);
  info["kind"] = "volume", info["file"] = path;
  info["format"] = fmt::format("{}, {}", header->format, scalar_name(header->scalar));
  info["holds"] = nullptr;
  command.warn(header->warnings);
  command.warn(reason.what);
  return info;
}

}  // namespace

bool may_be_volume(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return true;
  return format_of(path, &VolumeFormat::endings).format || format_of(path, &VolumeFormat::halves).format ||
         ending_of(path) == ".dcm";
}

Result<json> volume_info(const Command& command, const std::string& path, const std::string& quantity,
                         const Progress& progress) {
  const auto scanned = read_volume(command, path, quantity, progress);
  if (!scanned) {
    if (!quantity.empty() || scanned.error().kind != Error::Kind::use) return tl::unexpected(scanned.error());
    return without_quantity(command, path, scanned.error());
  }
  json info = grid_info(scanned->volume.grid);
  info["kind"] = "volume", info["file"] = path;
  info["format"] = scanned->format;
  if (!scanned->modality.empty()) info["modality"] = scanned->modality;
  if (!scanned->series_description.empty()) info["description"] = scanned->series_description;
  if (!scanned->pose.empty()) info["pose"] = scanned->pose;
  if (!scanned->sex.empty()) info["sex"] = scanned->sex;
  if (scanned->age_years) info["age_years"] = *scanned->age_years;
  info["quantity"] = quantity_name(scanned->volume.quantity);
  info["holds"] = scanned->reading;
  info["least"] = scanned->least, info["greatest"] = scanned->greatest;
  if (scanned->volume.quantity == Quantity::labels) {
    const auto labels = label_info(command, path);
    if (labels) {
      info["labels"] = *labels;
    } else {
      command.warn(labels.error().message());
    }
  }
  return info;
}

std::string volume_info_text(const json& info) {
  std::string text = info["file"].get<std::string>() + "\n";
  const auto line = [&](const std::string& name, const std::string& value) {
    text += fmt::format("  {:<12}{}\n", name, value);
  };
  const auto numbers = [&](const char* key) {
    const auto& v = info[key];
    return fmt::format("{:.6g} x {:.6g} x {:.6g}", v[0].get<double>(), v[1].get<double>(),
                       v[2].get<double>());
  };
  line("format", info["format"]);
  if (info.contains("modality")) line("modality", info["modality"]);
  if (info.contains("description")) line("description", info["description"]);
  if (info.contains("pose")) line("pose", info["pose"]);
  if (info.contains("sex")) line("sex", info["sex"]);
  if (info.contains("age_years")) line("age", fmt::format("{:.3g} years", info["age_years"].get<double>()));
  line("holds", info["holds"].is_null() ? "unclear" : info["holds"].get<std::string>());
  line("voxels", numbers("voxels"));
  line("spacing", numbers("spacing_mm") + " mm");
  for (std::size_t c = 0; c < 3; ++c)
    line(c ? "" : "axes", fmt::format("{} runs to {}", "ijk"[c], info["axes_run_to"][c].get<std::string>()));
  if (info["sheared"]) line("", "the axes are not perpendicular (sheared grid)");
  if (info.contains("least"))
    line("values", fmt::format("{} to {}", info["least"].get<double>(), info["greatest"].get<double>()));
  if (info.contains("labels"))
    for (const auto& label : info["labels"])
      line("label " + label["label"].dump(),
           fmt::format("{:<24}{:>10} voxels {:>12.1f} ml", label["name"].get<std::string>(),
                       label["voxels"].get<std::size_t>(), label["volume_ml"].get<double>()));
  return text;
}

}  // namespace borelli
