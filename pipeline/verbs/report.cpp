// borelli report FOLDER: draws report.html again from the files of a run's folder.
#include <fmt/core.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>

#include "error/json_text.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/export/deface.hpp"
#include "pipeline/export/glb.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/report/report.hpp"
#include "pipeline/stages/run_inputs.hpp"
#include "pipeline/stages/stages.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/verb.hpp"
#include "process/input_file.hpp"
#include "segmentation/files/landmarks_file.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct ReportAsked {
  std::string folder, volume, quantity, subject;
  bool deface = false;
};

/// Contents of the folder. The report's inputs point into it.
struct Found {
  std::optional<ScannedVolume> scan;
  std::optional<LabelMap> labels;
  std::optional<Landmarks> landmarks;
  std::optional<StoredTrajectory> motion;
  std::string glb;
  ReportInputs inputs;
};

/// Reads a file that may be absent (then null). Errors: damaged; values not of these `kinds`.
Result<json> json_if_there(const fs::path& path, const json& kinds) {
  std::error_code problem;
  if (!fs::exists(path, problem)) return json();
  const auto bytes = read_input_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto value = parse_json(*bytes, path.string());
  if (!value) return value;
  if (auto fine = check_kinds(*value, kinds, path.string()); !fine) return tl::unexpected(fine.error());
  return value;
}

template <class Target, class Answer>
Result<void> keep(Target& target, Answer&& answer) {
  if (!answer) return tl::unexpected(answer.error());
  target = std::move(*answer);
  return {};
}

/// Reads a binary glTF, whose header states its length (glTF 2.0, 4.4). Errors: damaged.
Result<std::string> read_glb(const fs::path& path) {
  auto bytes = read_input_file(path, any_size);
  if (!bytes) return bytes;
  std::uint32_t length = 0;
  if (bytes->size() >= 12) std::memcpy(&length, bytes->data() + 8, sizeof length);
  if (!bytes->starts_with("glTF") || length != bytes->size())
    return failure(path.string(),
                   "is not a binary glTF file, or is damaged or cut short; run `borelli run` again");
  return bytes;
}

/// Checks that the scan is, byte for byte, the one that the run read. (Without the run's account this cannot
/// be checked.)
Result<void> check_scan(const json& run, const std::string& path) {
  const json inputs = run.is_object() ? run.value("inputs", json()) : json();
  if (!inputs.is_object() || !inputs.contains("volume")) return {};
  RunSettings settings;
  settings.volume = path;
  const auto files = inputs_of(settings);
  if (!files) return tl::unexpected(files.error());
  const auto now = digests_of(*files, input_names(settings));
  if (!now) return tl::unexpected(now.error());
  const auto digests = [](const json& list) {
    std::vector<std::string> out;
    for (const json& file : list)
      out.push_back(file.is_object() && file.contains("sha256") ? file["sha256"].dump() : "");
    return out;
  };
  if (digests(now->at("volume")) == digests(inputs["volume"])) return {};
  return bad_use(path, "differs from the scan that the run read; name that scan with --volume");
}

/// The segmented scan: the one given by the user, else the one named in the account, if it still exists.
Result<void> find_scan(const ReportAsked& asked, const Command& command, Found& found) {
  std::string path = asked.volume;
  if (path.empty() && found.inputs.segmentation.is_object())
    path = found.inputs.segmentation.value("input", "");
  if (path.empty()) return {};
  if (std::error_code problem; asked.volume.empty() && !fs::exists(path, problem)) {
    command.warn(fmt::format(
        "cannot find the scan ({}), so the report shows the parts without it; name the scan with --volume",
        path));
    return {};
  }
  auto scan =
      check_scan(found.inputs.run, path).and_then([&] { return read_volume(command, path, asked.quantity); });
  if (!scan && asked.volume.empty()) {  // a report without grey values is better than none
    command.warn(fmt::format("the report shows the parts without the scan: {} (use --volume and --quantity)",
                             scan.error().message()));
    return {};
  }
  return keep(found.scan, std::move(scan));
}

Result<void> read_folder(const ReportAsked& asked, const Command& command, Found& found) {
  const fs::path folder = asked.folder;
  std::error_code problem;
  const auto there = [&](const char* name) { return fs::exists(folder / name, problem); };
  auto& inputs = found.inputs;
  Result<void> done = keep(inputs.segmentation, json_if_there(folder / "segmentation/segmentation.json",
                                                              {{"input", ""}, {"convention", ""}}));
  if (done)
    done = keep(inputs.table, json_if_there(folder / "inertia/table.json", {{"source", {{"segments", ""}}}}));
  if (done) done = keep(inputs.run, json_if_there(folder / "run.json", run_record_kinds()));
  if (done && there("segmentation/labels.nii.gz"))
    done = keep(found.labels, read_labels(command, (folder / "segmentation/labels.nii.gz").string()));
  if (done && there("segmentation/landmarks.json"))
    done = keep(found.landmarks, read_landmarks((folder / "segmentation/landmarks.json").string()));
  if (done && there("motion/trajectory.h5"))
    done = keep(found.motion, read_trajectory(folder / "motion/trajectory.h5"));
  if (done && there("motion/efforts.json"))
    done = keep(inputs.efforts, json_if_there(folder / "motion/efforts.json", {{"source", ""}}));
  if (done && there("body.glb")) done = keep(found.glb, read_glb(folder / "body.glb"));
  if (done) done = find_scan(asked, command, found);
  if (!done) return done;
  if (found.scan) inputs.grey = &found.scan->volume;
  if (found.labels) inputs.labels = &*found.labels;
  if (found.landmarks) inputs.landmarks = &*found.landmarks;
  if (found.motion) inputs.trajectory = &found.motion->trajectory;
  inputs.glb = found.glb;
  inputs.files = report_files(folder);
  inputs.subject =
      asked.subject.empty() ? fs::absolute(folder).lexically_normal().filename().string() : asked.subject;
  if (inputs.subject.empty()) inputs.subject = fs::absolute(folder).parent_path().filename().string();
  return {};
}

/// The body's surface as in found.glb, made again from the labels without the face.
Result<std::string> body_without_face(const Found& found, const fs::path& folder, const FaceCut& cut) {
  const auto table = read_table(folder / "inertia/table.json");
  if (!table) return tl::unexpected(table.error());
  MeshOptions options;
  if (const auto& run = found.inputs.run; run.is_object() && run.contains("settings"))
    options.tolerance = 1e-3 * run["settings"].value("mesh_tolerance_mm", 1e3 * options.tolerance);
  auto meshes = part_meshes(*found.labels, options);
  if (!meshes) return tl::unexpected(meshes.error());
  if (const auto done = deface(*meshes, *found.labels, cut, options); !done)
    return tl::unexpected(done.error());
  std::vector<Warning> said_by_the_scene;
  const ScanPoses X_WS = scan_poses(movable_parts(*table, said_by_the_scene), *found.landmarks);
  return glb(*meshes, X_WS, found.motion->trajectory, {found.inputs.subject});
}

/// Implements --deface: removes the face from the scan's copy and from the moving body. The body is left out
/// if it cannot be made again.
Result<void> show_no_face(Found& found, const Command& command, const fs::path& folder) {
  found.inputs.deface = true;
  const bool whole = found.labels && found.landmarks && found.motion && !found.inputs.table.is_null();
  const auto cut =
      found.labels ? face_cut(*found.labels, found.landmarks ? *found.landmarks : Landmarks()) : std::nullopt;
  if (!cut) command.warn(std::string(no_face_found));
  if (found.glb.empty() || (found.labels && !cut)) return {};
  if (whole) {
    if (auto kept = keep(found.glb, body_without_face(found, folder, *cut)); !kept) return kept;
  } else {
    found.glb.clear();
    command.warn(
        "the report shows no moving body: to remove its face it needs labels, landmarks, inertia table and "
        "trajectory");
  }
  found.inputs.glb = found.glb;
  return {};
}

/// Adds the verb's warnings to those of the run, for the page.
void show_warnings(const Command& command, Found& found) {
  json& run = found.inputs.run;
  const std::vector<std::string> warnings = command.warnings_in_files();
  if (warnings.empty()) return;
  if (run.is_null()) run = json::object();
  json& all = run["warnings"];
  for (const std::string& warning : warnings) all.push_back(warning);
}

Result<json> run(const ReportAsked& asked, const Command& command) {
  const fs::path folder = asked.folder;
  std::error_code problem;
  if (!fs::is_directory(folder, problem))
    return bad_use(asked.folder, "no such folder; expected the folder of a run");
  const auto path = folder / "report.html";
  if (auto fine = check_writable(path); !fine) return tl::unexpected(fine.error());
  Found found;
  if (const auto read = read_folder(asked, command, found); !read) return tl::unexpected(read.error());
  if (asked.deface)
    if (const auto done = show_no_face(found, command, folder); !done) return tl::unexpected(done.error());
  const auto& in = found.inputs;
  if (!in.labels && !in.trajectory && in.table.is_null() && in.glb.empty())
    return bad_use(asked.folder,
                   "contains no results of a run; expected segmentation/labels.nii.gz, inertia/table.json, "
                   "motion/trajectory.h5 or body.glb");
  show_warnings(command, found);
  const auto written = write_whole(path, [&](const fs::path& beside) { return write_report(in, beside); });
  if (!written) return tl::unexpected(written.error());
  if (!command.json) fmt::print("{}\n", path.string());
  return json{{"report", path.string()}, {"bytes", fs::file_size(path, problem)}};
}

}  // namespace

void add_report(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("report", "Write report.html again from the files in a run's folder");
  auto asked = std::make_shared<ReportAsked>();
  verb->add_option("folder", asked->folder, "Folder of a run")->required();
  add_shared(*verb, flags::volume, asked->volume, "; needed if the scan has moved since the run");
  add_shared(*verb, flags::quantity, asked->quantity, flags::quantity_default);
  add_shared(*verb, flags::subject, asked->subject, " (default: the folder's name)");
  add_shared(*verb, flags::deface, asked->deface);
  verb->callback(
      [&command, asked] { command.work = [asked](const Command& chosen) { return run(*asked, chosen); }; });
}

}  // namespace borelli
