#include "pipeline/stages/run.hpp"

#include <span>

#include "inertia/density.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/charts/motion_quantity.hpp"
#include "pipeline/files/folder_lock.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/stages/run_body.hpp"
#include "pipeline/stages/run_captured.hpp"
#include "pipeline/stages/run_data.hpp"
#include "pipeline/stages/run_inputs.hpp"
#include "pipeline/stages/run_scan.hpp"
#include "pipeline/stages/run_video.hpp"
#include "segmentation/labelling/segments.hpp"

namespace borelli {
namespace {

using nlohmann::json;

json settings_of(const RunSettings& s) {
  const InputNames names = input_names(s);
  return {{"subject", s.subject},
          {"volume", names.name_of(s.volume)},
          {"labels", names.name_of(s.labels)},
          {"label_names", names.name_of(s.label_names)},
          {"label_mapping", names.name_of(s.label_mapping)},
          {"landmarks", names.name_of(s.landmarks)},
          {"absent", s.absent},
          {"keep_paths", s.keep_paths},
          {"quantity", s.quantity ? json(quantity_name(*s.quantity)) : json()},
          {"sex", s.sex},
          {"pose", s.pose},
          {"stature_m", s.stature_m},
          {"density_curve", s.density_curve},
          {"convention", s.convention},
          {"frames", s.frames},
          {"segments", s.segments},
          {"accuracy", s.accuracy},
          {"method", s.method},
          {"equations", s.equations},
          {"work_grid_mm", s.work_grid_mm},
          {"table_tolerance", s.table_tolerance},
          {"model_tolerance", s.model_tolerance},
          {"motion_quantities", s.motion_quantities},
          {"integrator_tolerance", s.integrator_tolerance},
          {"step", s.step ? json(*s.step) : json()},
          {"mesh_tolerance_mm", s.mesh_tolerance_mm},
          {"skin", s.skin},
          {"deface", s.deface},
          {"video",
           {{"file", s.video},
            {"width", s.video_options.width},
            {"height", s.video_options.height},
            {"rate", s.video_options.rate},
            {"speed", s.video_options.speed},
            {"azimuth_deg", s.video_options.azimuth_deg},
            {"elevation_deg", s.video_options.elevation_deg},
            {"wire", s.video_options.style == FilmStyle::wire}}},
          {"allow_untrusted", s.untrusted_is_fine},
          {"captured",
           {{"motion", names.name_of(s.captured.motion)},
            {"forces", names.name_of(s.captured.forces)},
            {"trial", names.name_of(s.captured.trial)},
            {"marker_map", names.name_of(s.captured.marker_map)},
            {"other_person", s.captured.other_person},
            {"calibrate", s.captured.calibrate},
            {"recorded_mass", s.captured.recorded_mass},
            {"cutoff", s.captured.cutoff},
            {"band_draws", s.captured.band_draws},
            {"bvh_unit", s.captured.bvh_unit}}},
          {"leap",
           {{"flight_time", s.leap.flight_time},
            {"somersault_rate_deg", s.leap.somersault_rate_deg},
            {"tuck", s.leap.tuck},
            {"muscle_frequency", s.leap.muscle_frequency},
            {"damping_ratio", s.leap.damping_ratio}}}};
}

// The settings of one stage, by name, so that a changed setting reruns only what depends on it.
json pick(const json& all, std::initializer_list<const char*> names) {
  json some = json::object();
  for (const char* name : names) some[name] = all.at(name);
  return some;
}

Result<json> named(const RunData& data, Result<json> answer) {
  if (answer) *answer = data.names.without_folders(std::move(*answer));
  return answer;
}

/// The work of a stage that shows no progress.
template <class Work>
auto muted(RunData& data, Work work) {
  return [work, &data](const StageProgress&, const json&) { return named(data, work(data)); };
}

template <class Work>
auto shown_by(RunData& data, Work work) {
  return
      [work, &data](const StageProgress& progress, const json&) { return named(data, work(data, progress)); };
}

/// Adds the stages that show the body and write it for other programs.
void add_views(std::vector<Stage>& stages, RunData& data, const json& all) {
  const auto mute = [&data](auto work) { return muted(data, work); };
  stages.push_back({"mesh",
                    {"segmentation"},
                    pick(all, {"mesh_tolerance_mm", "deface"}),
                    {},
                    shown_by(data, make_meshes)});
  stages.push_back({"models",
                    {"skeleton", "mesh"},
                    json::object(),
                    {"model/body.osim", "model/body.xml"},
                    mute(write_models)});
  stages.push_back({"glb", {"mesh", "motion"}, json::object(), {"body.glb"}, mute(make_glb)});
  if (data.settings.skin)
    stages.push_back({"skin",
                      {"motion", "segmentation"},
                      pick(all, {"mesh_tolerance_mm"}),
                      {"skin.glb"},
                      mute(make_skin)});
  if (!data.settings.video.empty())
    stages.push_back({"video",
                      {"motion", "mesh"},
                      pick(all, {"video", "skin"}),
                      {data.settings.video},
                      shown_by(data, make_video)});
  stages.push_back({"picture", {"mesh"}, json::object(), {"body.png"}, mute(draw_picture)});
  // "slices" uses one core and waits for the meshes, which use all of them
  stages.push_back({"slices", {"segmentation"}, pick(all, {"deface"}), {}, mute(pack_scan), {}, {"mesh"}});
  stages.push_back({"report",
                    {"models", "glb", "picture", "slices"},
                    json::object(),
                    {"report.html"},
                    [&data](const StageProgress&, const json& record) { return write_page(data, record); }});
}

std::vector<std::string> segmentation_outputs(const RunSettings& settings) {
  std::vector<std::string> files;
  for (const std::string name : segmentation_file_names) files.push_back("segmentation/" + name);
  if (!settings.segments.empty())
    for (const std::string name : all_parts_file_names) files.push_back("segmentation/" + name);
  return files;
}

/// Landmarks that the user may edit and a later run keeps. The points for 3D Slicer are left out if the user
/// gives them back with --landmarks: they are then an input.
std::vector<EditableOutput> editable_landmarks(const RunSettings& settings) {
  std::vector<EditableOutput> files{{"segmentation/landmarks.json"}};
  const std::string points = "segmentation/landmarks.mrk.json";
  std::error_code absent;
  if (settings.landmarks.empty() ||
      !std::filesystem::equivalent(settings.landmarks, settings.folder / points, absent))
    files.push_back({points, "segmentation/landmarks.json"});
  return files;
}

/// `recorded`: digests of the captured motion's files.
std::vector<Stage> stages_of(RunData& data, const json& recorded) {
  const RunSettings& settings = data.settings;
  const json all = settings_of(settings);
  const auto mute = [&data](auto work) { return muted(data, work); };
  const auto shown = [&data](auto work) { return shown_by(data, work); };
  std::vector<Stage> stages;
  stages.push_back(
      {"segmentation",
       {},
       pick(all, {"quantity", "work_grid_mm", "table_tolerance", "label_mapping", "convention", "segments",
                  "keep_paths", "absent"}),
       segmentation_outputs(settings),
       shown(settings.labels.empty() || !settings.label_mapping.empty() ? segment_scan : use_given_labels),
       editable_landmarks(settings)});
  stages.push_back({"inertia",
                    {"segmentation"},
                    pick(all, {"sex", "pose", "stature_m", "density_curve", "convention", "frames"}),
                    {"inertia/table.csv", "inertia/table.json"},
                    mute(integrate_parts),
                    {{"inertia/table.csv", "inertia/table.json"}, {"inertia/table.json"}}});
  const bool captures = !settings.captured.motion.empty();
  stages.push_back({"skeleton",
                    {"inertia"},
                    captures ? pick(all, {"subject"})
                             : pick(all, {"subject", "leap", "accuracy", "method", "equations",
                                          "integrator_tolerance", "step"}),
                    {"model/scene.toml"},
                    mute(build_scene),
                    {{"model/scene.toml"}}});
  const bool smaller = settings.model_tolerance > 0;
  if (smaller)
    stages.push_back({"economy",
                      {"skeleton"},
                      pick(all, {"model_tolerance", "motion_quantities"}),
                      {"model/smallest.toml", "model/economy.html"},
                      shown(find_smallest)});
  if (captures)
    stages.push_back({"motion",
                      {"skeleton"},
                      {{"captured", all.at("captured")}, {"files", recorded}},
                      captured_outputs(settings.captured),
                      shown(capture_motion)});
  else
    stages.push_back({"motion",
                      {smaller ? "economy" : "skeleton"},
                      pick(all, {"allow_untrusted"}),
                      {"motion/trajectory.h5", "motion/trajectory.csv"},
                      shown(simulate_scene)});
  add_views(stages, data, all);
  return stages;
}

/// Checks whether the quantities can exist in the run's scene. An existing scene may be edited by the user,
/// so it is checked later, when it is used.
Result<void> check_quantities(const RunSettings& s) {
  std::error_code ignored;
  if (std::filesystem::exists(s.folder / "model/scene.toml", ignored)) return {};
  std::vector<std::string> segments;
  if (const auto choice = choose_segments(s.segments))
    for (const Segment& segment : *choice) segments.push_back(segment.name);
  if (segments.empty()) {
    for (const Part& part : std::span(parts).subspan(1)) segments.emplace_back(part.name);
    if (!s.labels.empty())  // labels may contain groups
      for (const SegmentGroup& group : segment_groups) segments.emplace_back(group.name);
  }
  const SkeletonNames names = skeleton_names(segments);
  for (const std::string& quantity : s.motion_quantities)
    if (auto fine = check_motion_quantity(quantity, names.solids, names.coordinates); !fine) return fine;
  return {};
}

}  // namespace

Result<json> run(const RunSettings& settings, bool force, const StageObserver& observer) {
  if (!settings.density_curve.empty())
    if (const auto curve = density_curve(settings.density_curve); !curve)
      return tl::unexpected(curve.error());
  if (auto fine = check_quantities(settings); !fine) return tl::unexpected(fine.error());
  const auto inputs = inputs_of(settings);
  if (!inputs) return tl::unexpected(inputs.error());
  const auto lock = FolderLock::take(settings.folder);
  if (!lock) return tl::unexpected(lock.error());
  if (auto fine = check_folder_writable(settings.folder / "mesh"); !fine) return tl::unexpected(fine.error());
  if (!settings.settings_text.empty())
    if (auto written = write_whole(settings.folder / "settings.toml", settings.settings_text); !written)
      return tl::unexpected(written.error());
  std::vector<RunInput> of_body, of_motion;
  for (const RunInput& input : *inputs) (is_captured(input) ? of_motion : of_body).push_back(input);
  const auto digests = digests_of(of_body, input_names(settings));
  if (!digests) return tl::unexpected(digests.error());
  const auto recorded = digests_of(of_motion, input_names(settings));
  if (!recorded) return tl::unexpected(recorded.error());
  json head{
      {"program", "borelli " BORELLI_VERSION}, {"inputs", *digests}, {"settings", settings_of(settings)}};
  RunData data(settings);
  const std::vector<Stage> stages = stages_of(data, *recorded);
  auto record = run_stages(*lock, head, stages, force, settings.threads, observer);
  if (!record)
    for (const std::string& warning : data.reader_warnings()) observer.warns(stages.front(), warning);
  return record;
}

}  // namespace borelli
