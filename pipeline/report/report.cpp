#include "pipeline/report/report.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <future>
#include <optional>

#include "pipeline/charts/page_frame.hpp"
#include "pipeline/export/certificate_report.hpp"
#include "pipeline/export/cut_lines.hpp"
#include "pipeline/export/deface.hpp"
#include "pipeline/export/fit_pictures.hpp"
#include "pipeline/export/glb.hpp"
#include "pipeline/export/histogram.hpp"
#include "pipeline/export/thumbnail.hpp"
#include "pipeline/files/palette.hpp"
#include "pipeline/report/effort_section.hpp"
#include "pipeline/report/static_numbers.hpp"
#include "segmentation/body/tissues.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "threads/slabs.hpp"

namespace borelli {

namespace data {
extern const char* const viewer_program;
extern const char* const viewer_style;
}  // namespace data

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string base64(std::string_view bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i)
      group = group << 8 | (at + i < bytes.size() ? static_cast<unsigned char>(bytes[at + i]) : 0);
    for (std::size_t i = 0; i < 4; ++i)
      text += at + i <= bytes.size() ? digits[group >> (18 - 6 * i) & 63] : '=';
  }
  return text;
}

Result<std::string> deflated(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), 4) != Z_OK)
    return failure("report.html", "not enough memory to compress its data");
  packed.resize(size);
  return packed;
}

std::string_view view_of(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

json vector_of(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

json quantity_of(const GreyVolume& grey) {
  switch (grey.quantity) {
    case Quantity::hu:
      return {{"quantity", "hu"}, {"unit", "HU"}};
    case Quantity::density_kgm3:
      return {{"quantity", "density_kgm3"}, {"unit", "kg/m³"}};
    case Quantity::labels:
      return {{"quantity", "labels"}, {"unit", ""}};
    case Quantity::mr:
      break;
  }
  return {{"quantity", "mr"}, {"unit", ""}};
}

json source_of(const ReportInputs& inputs) {
  const Grid* grid = inputs.grey ? &inputs.grey->grid : inputs.labels ? &inputs.labels->grid : nullptr;
  if (!grid) return nullptr;
  json source = inputs.grey ? quantity_of(*inputs.grey) : json{{"quantity", "labels"}, {"unit", ""}};
  source["size"] = grid->size;
  source["spacing"] = vector_of(grid->spacing());
  return source;
}

std::string css_colour(Colour c) { return fmt::format("#{:02x}{:02x}{:02x}", c.red, c.green, c.blue); }

/// All parts of the convention (for a table of some segments, only those), then other names in the label map.
json parts_of(const ReportInputs& inputs) {
  json list = json::array();
  const bool some = inputs.table.is_object() && inputs.table.contains("source") &&
                    inputs.table["source"].value("segments", "") != "";
  if (some && inputs.labels) {
    const auto& names = inputs.labels->names;
    for (std::size_t label = 1; label < names.size(); ++label)
      if (!names[label].empty())
        list.push_back(
            {{"name", names[label]}, {"colour", css_colour(part_colour(names[label]))}, {"label", label}});
    return list;
  }
  for (std::size_t label = 1; label < parts.size(); ++label)
    list.push_back({{"name", parts[label].name}, {"colour", css_colour(part_colours[label])}});
  if (!inputs.labels) return list;
  const auto& names = inputs.labels->names;
  for (std::size_t label = 1; label < names.size(); ++label) {
    const int known = part_label(names[label]);
    if (known == 0) list.push_back({{"name", names[label]}, {"colour", css_colour(part_colours[0])}});
    list[known > 0 ? static_cast<std::size_t>(known - 1) : list.size() - 1]["label"] = label;
  }
  return list;
}

/// Histogram of the whole scan's grey values; for CT numbers with the tissues' upper limits.
json histogram_of(const GreyVolume& grey, const LabelMap* labels) {
  const Histogram counted = histogram(grey, labels);
  json made{{"low", counted.low},     {"width", counted.width}, {"all", counted.all},
            {"below", counted.below}, {"above", counted.above}, {"tissues", json::array()}};
  if (!counted.body.empty()) made["body"] = counted.body;
  if (grey.quantity == Quantity::hu)
    made["tissues"] = {{{"name", "air"}, {"to", air_to_hu}},
                       {{"name", "lung"}, {"to", lung_to_hu}},
                       {{"name", "fat"}, {"to", fat_to_hu}},
                       {{"name", "soft tissue"}, {"to", soft_to_hu}},
                       {{"name", "bone"}, {"to", nullptr}}};
  return made;
}

/// Reach of the labels named `name` along the patient's z axis, m: lowest and highest voxel centre.
std::optional<std::pair<double, double>> reach_of(const LabelMap& labels, std::string_view name) {
  const auto found = std::ranges::find(labels.names, name);
  if (found == labels.names.end()) return std::nullopt;
  const auto label = std::uint8_t(found - labels.names.begin());
  const Grid& grid = labels.grid;
  std::optional<std::pair<double, double>> reach;
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j) {
      const double row = grid.origin[2] + grid.axes(2, 1) * double(j) + grid.axes(2, 2) * double(k);
      for (std::int64_t i = 0; i < grid.size[0]; ++i) {
        if (labels.at(i, j, k) != label) continue;
        const double z = 1e-3 * (row + grid.axes(2, 0) * double(i));
        if (!reach) reach = {z, z};
        reach = {std::min(reach->first, z), std::max(reach->second, z)};
      }
    }
  return reach;
}

/// The stature that the user gave; else the length of a whole body along the patient's z axis, from the top
/// of the head to the lower foot's end; null: neither is known.
json body_length(const ReportInputs& inputs) {
  const json& table = inputs.table;
  if (table.is_object() && table.contains("source"))
    if (const double given = table["source"].value("stature_m", 0.); given > 0)
      return {{"metres", given}, {"given", true}};
  if (!inputs.labels || !table.is_object() || !table.contains("body") ||
      table["body"].value("completeness", "") != "whole")
    return nullptr;
  const auto head = reach_of(*inputs.labels, "head"), left = reach_of(*inputs.labels, "foot_left"),
             right = reach_of(*inputs.labels, "foot_right");
  if (!head || !left || !right) return nullptr;
  const double voxel = 1e-3 * inputs.labels->grid.axes.row(2).cwiseAbs().sum();  // from centre to centre
  return {{"metres", head->second - std::min(left->first, right->first) + voxel}, {"given", false}};
}

json joints_of(const Landmarks& landmarks) {
  json list = json::array();
  for (const Part& part : parts) {
    const auto joint = landmarks.find(part.joint);
    if (part.joint.empty() || joint == landmarks.end()) continue;
    const Landmark& found = joint->second;
    list.push_back({{"name", joint->first},
                    {"point", vector_of(found.point)},
                    {"deviation", found.deviation},
                    {"source", found.source}});
  }
  return list;
}

/// Description of the pictures, whose grey values are appended to `bytes`.
json fits_of(const std::vector<FitPicture>& pictures, std::vector<std::uint8_t>& bytes) {
  json fits = json::array();
  for (const FitPicture& picture : pictures) {
    fits.push_back({{"joint", picture.joint},
                    {"radius", picture.fit.radius},
                    {"deviation", picture.fit.deviation},
                    {"source", picture.fit.source},
                    {"side", picture.side},
                    {"planes", json::array()}});
    for (const FitPlane& plane : picture.planes) {
      fits.back()["planes"].push_back(plane.name);
      bytes.insert(bytes.end(), plane.grey.begin(), plane.grey.end());
    }
  }
  return {{"pixels", FitPicture::pixels}, {"fits", fits}};
}

/// The cut planes as lines in the picture from the front; null if the convention is not one of ours, or no
/// plane is visible.
json cuts_of(const ReportInputs& inputs, const Thumbnail& copy) {
  if (!inputs.labels || !inputs.landmarks) return nullptr;
  std::string name = "deleva1996";
  if (inputs.segmentation.is_object()) name = inputs.segmentation.value("convention", name);
  const auto known = convention(name);
  if (!known) return nullptr;
  json lines = json::array();
  for (const CutLine& line : cut_lines(copy, inputs.labels->names, cut_planes(*inputs.landmarks, *known)))
    lines.push_back({{"joint", line.joint}, {"from", vector_of(line.from)}, {"to", vector_of(line.to)}});
  if (lines.empty() && *known != Convention::bone) return nullptr;
  return {{"convention", name}, {"lines", lines}};
}

/// Removes the face from the copy. Answers "taken" if the front of the head was removed, "hidden" if no head
/// was found and the copy shows only labelled parts.
const char* take_face(const ReportInputs& inputs, Thumbnail& copy) {
  const auto cut = inputs.labels
                       ? face_cut(*inputs.labels, inputs.landmarks ? *inputs.landmarks : Landmarks())
                       : std::nullopt;
  if (cut)
    deface(copy, *cut);
  else
    keep_labelled(copy);
  return cut ? "taken" : "hidden";
}

/// Curves of at most about 1500 points, which are samples of the trajectory.
json motion_of(const Trajectory& motion) {
  const double span = motion.times.empty() ? 0 : motion.times.back() - motion.times.front();
  const auto kept = kept_samples(motion.times, span > 0 ? 1500 / span : 1);
  const auto column = [&](const auto& value_at) {
    json values = json::array();
    for (const std::size_t i : kept) values.push_back(value_at(i));
    return values;
  };
  json curves = {{"times", column([&](std::size_t i) { return motion.times[i]; })},
                 {"solids", motion.solids.size()},
                 {"coordinates", motion.v.cols()},
                 {"certificate", json_of(motion.certificate)}};
  const auto series = [&](const char* name, const std::vector<double>& values) {
    if (values.size() == motion.times.size()) curves[name] = column([&](std::size_t i) { return values[i]; });
  };
  series("kinetic", motion.kinetic);
  series("potential", motion.potential);
  series("work", motion.work);
  if (motion.gravity_centre.rows() == std::ssize(motion.times) && motion.gravity_centre.cols() == 3)
    curves["gravity_centre"] = column([&](std::size_t i) -> json {
      return vector_of(motion.gravity_centre.row(static_cast<Eigen::Index>(i)).transpose());
    });
  const auto rows = std::min<Eigen::Index>(motion.multipliers.cols(), std::ssize(motion.multiplier_names));
  if (motion.multipliers.rows() == std::ssize(motion.times))
    for (Eigen::Index row = 0; row < rows; ++row)
      curves["multipliers"].push_back({{"name", motion.multiplier_names[static_cast<std::size_t>(row)]},
                                       {"values", column([&](std::size_t i) {
                                          return motion.multipliers(static_cast<Eigen::Index>(i), row);
                                        })}});
  return curves;
}

Result<std::string> block(const char* name, std::string_view bytes) {
  const auto packed = deflated(bytes);
  if (!packed) return tl::unexpected(packed.error());
  return fmt::format("<script type=\"text/plain\" id=\"block-{}\">{}</script>\n", name, base64(*packed));
}

}  // namespace

Result<ScanViews> scan_views(const ReportInputs& inputs) {
  ScanViews views{json::object(), {}};
  json& facts = views.facts;
  if (inputs.landmarks) facts["joints"] = joints_of(*inputs.landmarks);
  if (inputs.grey) facts["histogram"] = histogram_of(*inputs.grey, inputs.labels);

  Thumbnail copy;
  std::vector<std::uint8_t> fits;
  // compressed while the code below runs
  std::vector<std::future<Result<std::string>>> blocks;
  const auto add_block = [&](const char* name, std::string_view bytes) {
    blocks.push_back(std::async(aside(0), block, name, bytes));
  };
  if (inputs.grey || inputs.labels) {
    copy = thumbnail(inputs.grey, inputs.labels);
    if (inputs.deface) facts["face"] = take_face(inputs, copy);
    if (inputs.grey) add_block("grey", view_of(copy.grey));
    if (inputs.labels) add_block("labels", view_of(copy.labels));
    facts["volume"] = {{"size", copy.size},
                       {"spacing", copy.spacing},
                       {"origin", vector_of(copy.origin)},
                       {"low", copy.low},
                       {"high", copy.high}};
    facts["cuts"] = cuts_of(inputs, copy);
  }
  if (inputs.grey && inputs.landmarks) {
    facts["fits"] = fits_of(fit_pictures(*inputs.grey, *inputs.landmarks), fits);
    if (!fits.empty()) add_block("fits", view_of(fits));
  }
  for (auto& one : blocks) {
    const auto packed = one.get();
    if (!packed) return tl::unexpected(packed.error());
    views.packed += *packed;
  }
  return views;
}

Result<std::string> report_page(const ReportInputs& inputs) {
  std::future<Result<std::string>> body;  // compressed while the code below runs
  if (!inputs.glb.empty()) body = std::async(aside(0), block, "body", inputs.glb);
  ScanViews made;
  if (!inputs.views) {
    auto views = scan_views(inputs);
    if (!views) return tl::unexpected(views.error());
    made = std::move(*views);
  }
  const ScanViews& views = inputs.views ? *inputs.views : made;
  json report = {{"subject", inputs.subject}, {"source", source_of(inputs)},
                 {"parts", parts_of(inputs)}, {"segmentation", inputs.segmentation},
                 {"table", inputs.table},     {"run", inputs.run}};
  for (const auto& file : inputs.files)
    report["files"].push_back({{"path", file.path}, {"bytes", file.bytes}});
  if (inputs.trajectory) report["motion"] = motion_of(*inputs.trajectory);
  report.update(views.facts);
  report["length"] = body_length(inputs);
  std::string moments;
  if (!inputs.efforts.is_null()) {
    auto section = effort_section(inputs.efforts);
    if (!section) return tl::unexpected(section.error());
    report["efforts"] = std::move(section->page);
    moments = std::move(section->html);
  }

  std::string page =
      page_head(inputs.subject, data::viewer_style) + static_numbers(report) + moments + "</main>\n";
  page += "<script type=\"application/json\" id=\"report\">" + script_json(report) + "</script>\n";
  page += views.packed;
  if (body.valid()) {
    const auto packed = body.get();
    if (!packed) return tl::unexpected(packed.error());
    page += *packed;
  }
  page += page_end(data::viewer_program);
  return page;
}

Result<void> write_report(const ReportInputs& inputs, const fs::path& path) {
  const auto page = report_page(inputs);
  if (!page) return tl::unexpected(page.error());
  std::ofstream file(path, std::ios::binary);
  file.write(page->data(), static_cast<std::streamsize>(page->size()));
  file.close();
  if (!file)
    return failure(path.string(),
                   "cannot be written; check the folder's permissions and the free disk space");
  return {};
}

std::vector<ReportFile> report_files(const fs::path& folder) {
  constexpr std::array known{"segmentation/labels.nii.gz",
                             "segmentation/labels.tsv",
                             "segmentation/parts.nii.gz",
                             "segmentation/landmarks.json",
                             "inertia/table.csv",
                             "inertia/table.json",
                             "model/scene.toml",
                             "model/body.osim",
                             "model/body.xml",
                             "model/smallest.toml",
                             "model/captured.toml",
                             "model/economy.html",
                             "motion/trajectory.h5",
                             "motion/trajectory.csv",
                             "motion/angles.mot",
                             "motion/moments.sto",
                             "motion/powers.sto",
                             "motion/marker_errors.sto",
                             "motion/markers.trc",
                             "motion/trajectory.bvh",
                             "motion/efforts.json",
                             "body.glb",
                             "body.png",
                             "run.json"};
  std::vector<ReportFile> files;
  std::error_code absent;
  const auto add = [&](const std::string& path) {
    const auto bytes = fs::file_size(folder / path, absent);
    if (!absent) files.push_back({path, bytes});
  };
  for (const auto* path : known) add(path);
  std::vector<std::string> meshes;
  for (const auto& entry : fs::directory_iterator(folder / "mesh", absent))
    meshes.push_back("mesh/" + entry.path().filename().string());
  std::ranges::sort(meshes);
  for (const auto& mesh : meshes) add(mesh);
  return files;
}

}  // namespace borelli
