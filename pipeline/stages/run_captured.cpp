#include "pipeline/stages/run_captured.hpp"

#include <fmt/format.h>

#include <optional>

#include "dynamics/formats/scene_file.hpp"
#include "error/file_ending.hpp"
#include "error/json_text.hpp"
#include "pipeline/body/foot_soles.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/effort_bands.hpp"
#include "pipeline/motion/effort_report.hpp"
#include "pipeline/motion/motion_text.hpp"
#include "pipeline/motion/recorded_trajectory.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "pipeline/recordings/recording.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Warnings = std::vector<std::string>;

void append(Warnings& to, const Warnings& more) { to.insert(to.end(), more.begin(), more.end()); }

/// What the run's recording files hold.
struct ReadRecording {
  CapturedRecording recording;
  CapturedAngles angles;  ///< of a table of joint angles; `recording` is then empty
  PointKind kind = PointKind::markers;
  JointMapping own_markers;
  std::string in_words;
};

Result<ReadRecording> read_angles(const RunSettings& settings, const InputNames& names, Warnings& warnings) {
  const CapturedSettings& from = settings.captured;
  ReadRecording out;
  auto table = read_motion_table(from.motion);
  if (!table) return tl::unexpected(table.error());
  append(warnings, table->warnings);
  out.angles.angles = std::move(table->table);
  out.in_words = names.name_of(from.motion);
  if (from.forces.empty()) return out;
  auto forces = read_forces(from.forces);
  if (!forces) return tl::unexpected(forces.error());
  append(warnings, forces->warnings);
  out.angles.forces = std::move(forces->forces);
  out.angles.up = forces->up;
  out.in_words += " and " + names.name_of(from.forces);
  return out;
}

Result<ReadRecording> read_captured(const RunSettings& settings, const InputNames& names,
                                    Warnings& warnings) {
  const CapturedSettings& from = settings.captured;
  if (holds_angles(from)) return read_angles(settings, names, warnings);
  ReadRecording out;
  auto motion = read_recording(from.motion, from.bvh_unit);
  if (!motion) return tl::unexpected(motion.error());
  append(warnings, motion->warnings);
  out.recording.motion = std::move(motion->markers);
  if (motion->joint_centres) out.kind = PointKind::joints;
  out.in_words = names.name_of(from.motion);
  out.recording.forces = std::move(motion->forces);
  if (!from.forces.empty()) {
    auto forces = read_forces(from.forces);
    if (!forces) return tl::unexpected(forces.error());
    append(warnings, forces->warnings);
    if (forces->up && from.forces != from.motion)
      return bad_use(from.forces,
                     "may use other axes than the markers' file; give this .c3d with --motion too, or give "
                     "the forces as a table (.mot)");
    out.recording.forces = std::move(forces->forces);
    out.in_words += " and " + names.name_of(from.forces);
  }
  if (!from.trial.empty()) {
    auto trial = read_recording(from.trial, from.bvh_unit);
    if (!trial) return tl::unexpected(trial.error());
    append(warnings, trial->warnings);
    out.recording.trial = std::move(trial->markers);
  }
  if (!from.marker_map.empty()) {
    auto own = read_joint_mapping(from.marker_map, marker_places());
    if (!own) return tl::unexpected(own.error());
    out.own_markers = std::move(*own);
  }
  return out;
}

Result<void> write_table(const MotionTable& table, const fs::path& path) {
  const auto text = motion_table_text(table, path.string());
  return text ? write_whole(path, *text) : tl::unexpected(text.error());
}

/// The efforts' table, with a column of deviations for each.
MotionTable moments_with_deviations(const System& system, const RecordedEfforts& efforts,
                                    const std::optional<EffortBands>& bands) {
  MotionTable table = effort_table_of(system, efforts);
  if (!bands) return table;
  const Eigen::Index n = table.values.cols();
  for (Eigen::Index u = 0; u < n; ++u) table.columns.push_back(table.columns[std::size_t(u)] + "_sd");
  table.values.conservativeResize(Eigen::NoChange, 2 * n);
  table.values.rightCols(n) = bands->deviation;
  return table;
}

/// The motion as a skeleton, and its markers with their errors.
Result<void> write_motion(RunData& data, const CapturedMotion& motion, const Trajectory& trajectory) {
  std::vector<const char*> names{"motion/trajectory.bvh"};
  if (!motion.fit.markers.empty()) names.push_back("motion/markers.trc");
  for (const char* name : names) {
    const auto text = motion_text(motion.scene, trajectory, data.file(name).string());
    if (!text) return tl::unexpected(text.error());
    if (auto done = write_whole(data.file(name), *text); !done) return done;
  }
  if (motion.fit.markers.empty()) return {};
  return write_table(error_table_of(motion.fit), data.file("motion/marker_errors.sto"));
}

Result<void> write_captured(RunData& data, const CapturedMotion& motion, const System& system,
                            const std::optional<EffortBands>& bands, const std::string& source) {
  const auto trajectory = recorded_trajectory(system, motion.efforts);
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto text = write_scene(motion.scene);
  if (!text) return tl::unexpected(text.error());
  if (auto done = write_whole(data.file("model/captured.toml"), *text); !done) return done;
  for (const char* name : {"motion/trajectory.h5", "motion/trajectory.csv"})
    if (auto done =
            write_whole(data.file(name),
                        [&](const fs::path& beside) { return write_trajectory(*trajectory, *text, beside); });
        !done)
      return done;
  MotionFit smooth = motion.fit;
  smooth.times = motion.positions.times;
  smooth.q = motion.positions.q;
  if (auto done = write_table(table_of(system, smooth), data.file("motion/angles.mot")); !done) return done;
  if (auto done = write_table(moments_with_deviations(system, motion.efforts, bands),
                              data.file("motion/moments.sto"));
      !done)
    return done;
  if (auto done = write_table(power_table_of(system, motion.efforts), data.file("motion/powers.sto")); !done)
    return done;
  if (const auto done = write_motion(data, motion, *trajectory); !done) return done;
  const json report = effort_report(motion, system, bands, source);
  return write_whole(data.file("motion/efforts.json"), json_text(report, -1) + "\n");
}

Result<CapturedMotion> captured_by(const BodyModel& body, const Landmarks& landmarks,
                                   const ReadRecording& read, const CapturedMotionRequest& request) {
  if (!read.angles.angles.columns.empty()) return captured_angles(body, landmarks, read.angles, request);
  std::vector<std::string> segments;
  for (const Solid& solid : body.scene.solids) segments.push_back(solid.name);
  const BodyMarkers markers =
      body_markers(read.recording.motion.names, landmarks, segments, read.kind, read.own_markers);
  return captured_motion(body, markers, read.recording, request);
}

json entry_of(const CapturedMotion& motion, const std::optional<EffortBands>& bands, Warnings warnings) {
  append(warnings, motion.warnings);
  json entry{{"warnings", warnings},
             {"length_ratio", motion.length_ratio},
             {"mass_ratio", motion.mass_ratio},
             {"root_residuals", residual_report(motion.efforts)}};
  if (!motion.fit.markers.empty()) {
    entry["marker_error_mm"] = 1e3 * motion.fit.rms();
    entry["landmark_distance_mm"] = 1e3 * motion.landmark_distance;
  }
  if (bands) entry["failed_draws"] = bands->failed;
  return entry;
}

}  // namespace

bool holds_angles(const CapturedSettings& settings) {
  const std::string ending = ending_of(settings.motion);
  return ending == ".mot" || ending == ".sto";
}

std::vector<std::string> captured_outputs(const CapturedSettings& settings) {
  std::vector<std::string> out{"model/captured.toml", "motion/trajectory.h5", "motion/trajectory.csv",
                               "motion/angles.mot",   "motion/moments.sto",   "motion/powers.sto",
                               "motion/efforts.json", "motion/trajectory.bvh"};
  if (!holds_angles(settings)) out.insert(out.end(), {"motion/marker_errors.sto", "motion/markers.trc"});
  return out;
}

Result<json> capture_motion(RunData& data, const StageProgress& progress) {
  const auto scene = data.scene();
  if (!scene) return tl::unexpected(scene.error());
  const auto table = data.table();
  if (!table) return tl::unexpected(table.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  const Landmarks& landmarks = (*segmentation)->landmarks;
  Warnings warnings;
  const auto read = read_captured(data.settings, data.names, warnings);
  if (!read) return tl::unexpected(read.error());
  const CapturedSettings& settings = data.settings.captured;
  CapturedMotionRequest request;
  request.other_person = settings.other_person;
  request.calibrate = settings.calibrate;
  if (settings.recorded_mass > 0) request.recorded_mass = settings.recorded_mass;
  request.cutoff = settings.cutoff;
  request.progress = [&](double done) { progress(0.3 * done); };
  BodyModel body{**scene, {}};
  if (settings.other_person) body.soles = foot_soles((*segmentation)->labels, landmarks);
  const auto motion = captured_by(body, landmarks, *read, request);
  if (!motion) return tl::unexpected(motion.error());

  std::optional<EffortBands> bands;
  if (settings.band_draws > 0 && (*table)->causes.empty()) {
    warnings.emplace_back(
        "the inertia table has no standard deviations, so the joint moments have no error bands");
  } else if (settings.band_draws > 0) {
    EffortBandRequest asked;
    asked.samples = settings.band_draws;
    asked.cutoff = settings.cutoff;
    asked.threads = data.settings.threads;
    asked.progress = [&](double done) { progress(0.3 + 0.7 * done); };
    auto found = effort_bands(*motion, {**table, landmarks, read->kind, read->own_markers}, asked);
    if (!found) return tl::unexpected(found.error());
    bands = std::move(*found);
  }
  const auto system = compile(motion->scene);
  if (!system) return tl::unexpected(system.error());
  if (auto written = write_captured(data, *motion, *system, bands, read->in_words); !written)
    return tl::unexpected(written.error());
  return entry_of(*motion, bands, std::move(warnings));
}

}  // namespace borelli
