#include "pipeline/run.hpp"

#include <fmt/core.h>

#include "dynamics/integrator.hpp"
#include "dynamics/scene_file.hpp"
#include "dynamics/simulate.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/certificate_report.hpp"
#include "pipeline/deface.hpp"
#include "pipeline/display.hpp"
#include "pipeline/folder_lock.hpp"
#include "pipeline/given_labels.hpp"
#include "pipeline/glb.hpp"
#include "pipeline/measure.hpp"
#include "pipeline/mesh.hpp"
#include "pipeline/mesh_file.hpp"
#include "pipeline/mr_scan.hpp"
#include "pipeline/range_warning.hpp"
#include "pipeline/render.hpp"
#include "pipeline/report.hpp"
#include "pipeline/run_inputs.hpp"
#include "pipeline/segmentation_files.hpp"
#include "pipeline/table_tolerance.hpp"
#include "pipeline/trajectory_file.hpp"
#include "pipeline/whole_file.hpp"
#include "segmentation/given_landmarks.hpp"
#include "segmentation/landmarks_file.hpp"
#include "segmentation/read.hpp"
#include "segmentation/segment.hpp"
#include "segmentation/write.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A segmentation from the files that it was written to.
Result<Segmentation> read_back(const fs::path& folder, const std::string& segments) {
  Segmentation found;
  auto labels = read_labels((folder / (segments.empty() ? "labels.nii.gz" : "parts.nii.gz")).string());
  if (!labels) return tl::unexpected(labels.error());
  auto asked = choose_segments(segments, labels->names);
  if (!asked) return tl::unexpected(asked.error());
  auto landmarks = read_landmarks((folder / "landmarks.json").string());
  if (!landmarks) return tl::unexpected(landmarks.error());
  auto findings = read_findings(folder / "segmentation.json");
  if (!findings) return tl::unexpected(findings.error());
  found.labels = std::move(*labels);
  found.landmarks = std::move(*landmarks);
  found.part = *findings;
  found.asked = std::move(*asked);
  return found;
}

// What the stages hand on. Each is read from its file when a stage asks for it and no stage before it in this
// run made it.
class RunData {
 public:
  explicit RunData(const RunSettings& settings) : settings_(settings) {}

  Result<const ScannedVolume*> scan(const Progress& progress = {}) {
    return once(scan_, [&]() -> Result<ScannedVolume> {
      auto read = read_volume(settings_.volume, {settings_.quantity, progress});
      if (read && !settings_.density_curve.empty() && read->volume.quantity != Quantity::hu)
        return bad_use("--density-curve",
                       "is from CT numbers, and " + settings_.volume + " holds none: leave it out");
      return read;
    });
  }
  /// The classes of somebody else's label map; nothing where none is given.
  Result<const ClassMap*> classes() {
    if (settings_.label_mapping.empty()) return nullptr;
    return once(classes_, [&] {
      return read_classes(settings_.labels, settings_.label_names, settings_.label_mapping);
    });
  }
  /// The reading of an MR scan.
  Result<const MrReading*> mr() {
    return once(mr_, [&]() -> Result<MrReading> {
      const auto scanned = scan();
      if (!scanned) return tl::unexpected(scanned.error());
      const auto told = classes();
      if (!told) return tl::unexpected(told.error());
      return read_mr((*scanned)->volume, *told, settings_.threads);
    });
  }
  Result<const Segmentation*> segmentation() {
    return once(segmentation_,
                [&] { return read_back(settings_.folder / "segmentation", settings_.segments); });
  }
  /// The labels of the segments that are asked for.
  Result<const LabelMap*> labels() {
    const auto found = segmentation();
    if (!found) return tl::unexpected(found.error());
    if ((*found)->asked.empty()) return &(*found)->labels;
    return once(labels_,
                [&]() -> Result<LabelMap> { return labels_of_segments((*found)->labels, (*found)->asked); });
  }
  Result<const InertiaTable*> table() {
    return once(table_, [&] { return read_table(settings_.folder / "inertia/table.json"); });
  }
  Result<const Scene*> scene() {
    return once(scene_, [&] { return read_scene(settings_.folder / "model/scene.toml"); });
  }
  Result<const Trajectory*> trajectory() {
    return once(trajectory_, [&]() -> Result<Trajectory> {
      auto stored = read_trajectory(settings_.folder / "motion/trajectory.h5");
      if (!stored) return tl::unexpected(stored.error());
      return std::move(stored->trajectory);
    });
  }
  Result<const std::vector<Mesh>*> meshes() {
    return once(meshes_, [&]() -> Result<std::vector<Mesh>> {
      std::vector<Mesh> stored;
      const auto asked = labels();
      if (!asked) return tl::unexpected(asked.error());
      for (const std::string& name : (*asked)->names) {
        const fs::path path = settings_.folder / "mesh" / (name + ".vtp");
        if (!fs::exists(path)) continue;  // a part without voxels
        auto mesh = read_vtp(path.string());
        if (!mesh) return tl::unexpected(mesh.error());
        stored.push_back(std::move(*mesh));
      }
      return stored;
    });
  }
  void keep(Segmentation made) { segmentation_ = std::move(made); }
  void keep(InertiaTable made) { table_ = std::move(made); }
  void keep(Scene made) { scene_ = std::move(made); }
  void keep(Trajectory made) { trajectory_ = std::move(made); }
  void keep(std::vector<Mesh> made) { meshes_ = std::move(made); }

 private:
  template <class T, class Make>
  static Result<const T*> once(std::optional<T>& held, Make make) {
    if (!held) {
      auto made = make();
      if (!made) return tl::unexpected(made.error());
      held = std::move(*made);
    }
    return &*held;
  }

  const RunSettings& settings_;
  std::optional<ScannedVolume> scan_;
  std::optional<ClassMap> classes_;
  std::optional<MrReading> mr_;
  std::optional<Segmentation> segmentation_;
  std::optional<LabelMap> labels_;
  std::optional<InertiaTable> table_;
  std::optional<Scene> scene_;
  std::optional<Trajectory> trajectory_;
  std::optional<std::vector<Mesh>> meshes_;
};

using Warnings = std::vector<std::string>;

class Run {
 public:
  explicit Run(const RunSettings& settings) : settings_(settings), data_(settings) {}

  Result<json> segment_scan(const Progress& progress);
  Result<json> use_given_labels(const Progress& progress);
  Result<json> integrate();
  Result<json> build_scene();
  Result<json> move(const Progress& progress);
  Result<json> make_meshes(const Progress& progress);
  Result<json> make_glb();
  Result<json> draw_picture();
  Result<json> write_page(const json& record);

 private:
  fs::path file(const std::string& name) const { return settings_.folder / name; }
  Result<Segmentation> part_scan(const GreyVolume& volume, const SegmentOptions& options);
  MeasureOptions measuring() const;
  Result<void> take_face(std::vector<Mesh>& meshes, const LabelMap& labels, const Landmarks& landmarks,
                         Warnings& warnings) const;
  Result<json> hand_on(Segmentation& found, const ScannedVolume& scan);

  const RunSettings& settings_;
  RunData data_;
  std::optional<GridPick> pick_;  // where a tolerance picked the grid
};

Result<json> Run::hand_on(Segmentation& found, const ScannedVolume& scan) {
  auto asked = choose_segments(settings_.segments, found.labels.names);
  if (!asked) return tl::unexpected(asked.error());
  found.asked = std::move(*asked);
  json account = segmentation_account(found, settings_.volume, scan.reading);
  account["convention"] = settings_.convention;
  if (pick_) account["tolerance"] = to_json(*pick_);
  if (auto written = write_segmentation(file("segmentation"), found, account, settings_.landmarks); !written)
    return tl::unexpected(written.error());
  json parts_found = json::object();
  for (const auto& [name, part] : account["parts"].items()) parts_found[name] = part["coverage"];
  json answer{{"warnings", found.warnings},
              {"reading", scan.reading},
              {"format", scan.format},
              {"parts", parts_found}};
  if (pick_) answer["tolerance"] = account["tolerance"];
  return answer;
}

MeasureOptions Run::measuring() const {
  MeasureOptions options;
  options.density_curve = settings_.density_curve;
  options.sex = settings_.sex;
  options.pose = settings_.pose;
  options.cuts = settings_.convention;
  options.frames = settings_.frames;
  options.threads = settings_.threads;
  return options;
}

Result<Segmentation> Run::part_scan(const GreyVolume& volume, const SegmentOptions& options) {
  if (settings_.table_tolerance > 0 && volume.quantity != Quantity::mr) {
    // not by what the segmentation does not depend on
    MeasureOptions by;
    by.cuts = settings_.convention, by.threads = settings_.threads;
    auto asked = choose_segments(settings_.segments);
    if (!asked) return tl::unexpected(asked.error());
    by.segments = std::move(*asked);
    auto found = segment_within(volume, settings_.table_tolerance, options, by, pick_.emplace());
    if (found && !pick_->met) found->warnings.push_back(in_words(*pick_));
    return found;
  }
  if (volume.quantity != Quantity::mr) return segment(volume, options);
  if (settings_.table_tolerance > 0)
    return bad_use("--table-tolerance", "is for CT, where parts are found on a grid: leave it out");
  const auto reading = data_.mr();
  if (!reading) return tl::unexpected(reading.error());
  return segment_mr(**reading, options);
}

Result<json> Run::segment_scan(const Progress& progress) {
  const auto scan = data_.scan([&](double share) { progress(0.2 * share); });
  if (!scan) return tl::unexpected(scan.error());
  SegmentOptions options{settings_.work_grid_mm, settings_.threads};
  const auto cuts = convention(settings_.convention);
  if (!cuts) return tl::unexpected(cuts.error());
  options.convention = *cuts;
  options.progress = [&](double share, std::string_view) { progress(0.2 + 0.7 * share); };
  const auto classes = data_.classes();
  if (!classes) return tl::unexpected(classes.error());
  options.classes = *classes;
  Warnings told;
  if (!settings_.landmarks.empty()) {
    auto given = read_given_landmarks(settings_.landmarks);
    if (!given) return tl::unexpected(given.error());
    options.given = std::move(given->landmarks);
    told = std::move(given->warnings);
  }
  auto found = part_scan((*scan)->volume, options);
  if (!found) return tl::unexpected(found.error());
  for (const auto& list : {told, (*scan)->warnings})
    found->warnings.insert(found->warnings.begin(), list.begin(), list.end());
  auto answer = hand_on(*found, **scan);
  data_.keep(std::move(*found));
  return answer;
}

Result<json> Run::use_given_labels(const Progress& progress) {
  const auto scan = data_.scan([&](double share) { progress(0.5 * share); });
  if (!scan) return tl::unexpected(scan.error());
  auto labels = read_labels(settings_.labels, settings_.label_names);
  if (!labels) return tl::unexpected(labels.error());
  if (!same_grid(labels->grid, (*scan)->volume.grid) && same_lattice(labels->grid, (*scan)->volume.grid))
    *labels = labels_on(*labels, (*scan)->volume.grid, settings_.threads);
  if (!same_grid(labels->grid, (*scan)->volume.grid))
    return bad_use(settings_.labels,
                   "lies on another grid than " + settings_.volume + "; resample one onto the other");
  GivenLandmarks given;
  if (!settings_.landmarks.empty()) {
    auto read = read_given_landmarks(settings_.landmarks);
    if (!read) return tl::unexpected(read.error());
    given = std::move(*read);
  }
  Landmarks landmarks;
  put_given(given.landmarks, landmarks);
  Segmentation found = segmentation_of(std::move(*labels), std::move(landmarks));
  found.warnings = std::move(given.warnings);
  if (found.landmarks.empty())
    found.warnings.push_back(
        "no landmarks were given with the labels: joints are welded and segment frames unknown");
  auto answer = hand_on(found, **scan);
  data_.keep(std::move(found));
  return answer;
}

Result<json> Run::integrate() {
  const auto scan = data_.scan();
  if (!scan) return tl::unexpected(scan.error());
  const auto segmentation = data_.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  MeasureOptions options = measuring();
  options.segments = (*segmentation)->asked;
  const GreyVolume* weighed = &(*scan)->volume;
  if (weighed->quantity == Quantity::mr) {
    const auto reading = data_.mr();
    if (!reading) return tl::unexpected(reading.error());
    weighed = &(*reading)->density;
  }
  auto table = measure(*weighed, (*segmentation)->labels, (*segmentation)->landmarks, options,
                       completeness_of((*segmentation)->part));
  if (!table) return tl::unexpected(table.error());
  table->source.volume = settings_.volume;
  table->source.quantity = (*scan)->reading;
  for (const char* name : {"inertia/table.csv", "inertia/table.json"})
    if (auto written =
            write_whole(file(name), [&](const fs::path& beside) { return write_table(beside, *table); });
        !written)
      return tl::unexpected(written.error());
  Warnings warnings;
  for (const InertiaRow& row : table->rows)
    if (!row.flaw.empty()) warnings.push_back(row.part + ": " + row.flaw);
  if (settings_.table_tolerance > 0)
    if (auto beyond = beyond_the_voxels(*table, settings_.table_tolerance); !beyond.empty())
      warnings.push_back(std::move(beyond));
  json answer{{"warnings", warnings},
              {"mass_kg", table->whole.inertial.mass},
              {"density_curve", table->source.density_curve},
              {"sampling", table->source.sampling}};
  data_.keep(std::move(*table));
  return answer;
}

Result<json> Run::build_scene() {
  const auto table = data_.table();
  if (!table) return tl::unexpected(table.error());
  const auto segmentation = data_.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  Warnings warnings;
  const PartInertials present = movable_parts(**table, warnings);
  if (present.empty())
    if (const auto scan = data_.scan(); scan && (*scan)->volume.quantity == Quantity::mr)
      return failure(
          settings_.volume,
          "is MR, in which no part can be told by itself: segmentation/labels.nii.gz and inertia/table.csv "
          "hold "
          "its tissues; for a body that moves give a label map (--labels with --label-mapping) or the joints "
          "(--landmarks)");
  SkeletonOptions options{settings_.subject, settings_.leap};
  auto skeleton = build_skeleton(present, (*segmentation)->landmarks, options);
  if (!skeleton) return tl::unexpected(skeleton.error());
  skeleton->scene.simulation.method = settings_.method;
  skeleton->scene.simulation.equations =
      settings_.equations == "lagrange" ? Equations::lagrange : Equations::recursive;
  skeleton->scene.simulation.tolerance = settings_.tolerance;
  skeleton->scene.simulation.step = settings_.step.value_or(skeleton->scene.simulation.step);
  const auto text = write_scene(skeleton->scene);
  if (!text) return tl::unexpected(text.error());
  if (auto written = write_whole(file("model/scene.toml"), *text); !written)
    return tl::unexpected(written.error());
  warnings.insert(warnings.end(), skeleton->warnings.begin(), skeleton->warnings.end());
  data_.keep(std::move(skeleton->scene));
  return json{{"warnings", warnings}};
}

Result<json> Run::move(const Progress& progress) {
  const auto scene = data_.scene();
  if (!scene) return tl::unexpected(scene.error());
  const auto system = compile(**scene);
  if (!system) return tl::unexpected(system.error());
  const double end = (*scene)->simulation.end_time;
  auto trajectory = simulate(*system, system->initial, system->settings, {[&](double t) {
    progress(t / end);
    return true;
  }});
  if (!trajectory) return tl::unexpected(trajectory.error());
  const Certificate& certificate = trajectory->certificate;
  if (!certificate.trusted && !settings_.untrusted_is_fine)
    return failure(
        (*scene)->name,
        fmt::format("the motion is not to be trusted: {} ({}--allow-untrusted goes on with it)",
                    certificate.reason,
                    method_is_adaptive((*scene)->simulation.method) ? "" : "give a shorter --step; "));
  const auto text = write_scene(**scene);
  if (!text) return tl::unexpected(text.error());
  for (const char* name : {"motion/trajectory.h5", "motion/trajectory.csv"})
    if (auto written = write_whole(
            file(name), [&](const fs::path& beside) { return write_trajectory(*trajectory, *text, beside); });
        !written)
      return tl::unexpected(written.error());
  Warnings warnings = warnings_of(certificate, *system);
  if (!certificate.trusted) warnings.push_back("the motion is not to be trusted: " + certificate.reason);
  json answer{{"warnings", warnings}, {"certificate", json_of(certificate)}};
  data_.keep(std::move(*trajectory));
  return answer;
}

Result<void> Run::take_face(std::vector<Mesh>& meshes, const LabelMap& labels, const Landmarks& landmarks,
                            Warnings& warnings) const {
  const auto cut = face_cut(labels, landmarks);
  if (cut) return deface(meshes, labels, *cut, {1e-3 * settings_.mesh_tolerance_mm, settings_.threads, {}});
  warnings.emplace_back(no_face_found);
  return {};
}

Result<json> Run::make_meshes(const Progress& progress) {
  const auto segmentation = data_.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  const auto labels = data_.labels();
  if (!labels) return tl::unexpected(labels.error());
  auto meshes = part_meshes(**labels, {1e-3 * settings_.mesh_tolerance_mm, settings_.threads, progress});
  if (!meshes) return tl::unexpected(meshes.error());
  Warnings warnings;
  if (settings_.deface) {
    if (auto done = take_face(*meshes, (*segmentation)->labels, (*segmentation)->landmarks, warnings); !done)
      return tl::unexpected(done.error());
  }
  std::error_code ignored;
  fs::remove_all(file("mesh"), ignored);  // of parts that an earlier run found and this one does not
  const auto written = write_meshes(file("mesh"), *meshes);
  if (!written) return tl::unexpected(written.error());
  json counts = json::object();
  for (const Mesh& mesh : *meshes) counts[mesh.name] = mesh.triangles.size();
  json files = json::array();
  for (const fs::path& path : *written) files.push_back(path.lexically_relative(settings_.folder).string());
  data_.keep(std::move(*meshes));
  return json{{"triangles", counts}, {"files", files}, {"warnings", warnings}};
}

Result<json> Run::make_glb() {
  const auto meshes = data_.meshes();
  if (!meshes) return tl::unexpected(meshes.error());
  const auto table = data_.table();
  if (!table) return tl::unexpected(table.error());
  const auto segmentation = data_.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  const auto trajectory = data_.trajectory();
  if (!trajectory) return tl::unexpected(trajectory.error());
  Warnings said_by_the_scene;
  const ScanPoses X_WS = scan_poses(movable_parts(**table, said_by_the_scene), (*segmentation)->landmarks);
  const auto bytes = glb(**meshes, X_WS, **trajectory, {settings_.subject});
  if (!bytes) return tl::unexpected(bytes.error());
  if (auto written = write_whole(file("body.glb"), *bytes); !written) return tl::unexpected(written.error());
  return json::object();
}

Result<json> Run::draw_picture() {
  if (!display_answers()) {
    std::error_code ignored;
    fs::remove(file("body.png"), ignored);  // of an earlier run with other parts
    return json{
        {"warnings",
         {"no picture (body.png): there is no X display; run the program as 'xvfb-run -a borelli ...'"}},
        {"files", json::array()},
        {"key", ""}};
  }
  const auto meshes = data_.meshes();
  if (!meshes) return tl::unexpected(meshes.error());
  const auto segmentation = data_.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  PictureOptions options;
  std::vector<std::string> shown;
  for (const Mesh& mesh : **meshes) shown.push_back(mesh.name);
  for (const Part& part : segment_tree(shown))
    if (const auto joint = (*segmentation)->landmarks.find(part.joint);
        joint != (*segmentation)->landmarks.end())
      options.joints.push_back(1e-3 * joint->second.point);
  auto drawn = write_whole(file("body.png"), [&](const fs::path& beside) {
    return draw_body(beside.string(), **meshes, options);
  });
  if (!drawn) return tl::unexpected(drawn.error());
  return json::object();
}

Result<json> Run::write_page(const json& record) {
  ReportInputs page;
  page.subject = settings_.subject;
  const auto scan = data_.scan();
  if (!scan) return tl::unexpected(scan.error());
  const auto segmentation = data_.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  const auto trajectory = data_.trajectory();
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto table = read_whole(file("inertia/table.json"));
  if (!table) return tl::unexpected(table.error());
  const auto account = read_whole(file("segmentation/segmentation.json"));
  if (!account) return tl::unexpected(account.error());
  const auto body = read_whole(file("body.glb"));
  if (!body) return tl::unexpected(body.error());
  page.grey = &(*scan)->volume;
  const auto labels = data_.labels();
  if (!labels) return tl::unexpected(labels.error());
  page.labels = *labels;
  page.landmarks = &(*segmentation)->landmarks;
  page.table = json::parse(*table);
  page.segmentation = json::parse(*account);
  page.trajectory = *trajectory;
  page.glb = *body;
  page.run = record;
  page.deface = settings_.deface;
  page.files = report_files(settings_.folder);
  auto written =
      write_whole(file("report.html"), [&](const fs::path& beside) { return write_report(page, beside); });
  if (!written) return tl::unexpected(written.error());
  return json::object();
}

json settings_of(const RunSettings& s) {
  return {{"subject", s.subject},
          {"volume", s.volume},
          {"labels", s.labels},
          {"label_names", s.label_names},
          {"label_mapping", s.label_mapping},
          {"landmarks", s.landmarks},
          {"quantity", s.quantity ? json(quantity_name(*s.quantity)) : json()},
          {"sex", s.sex},
          {"pose", s.pose},
          {"density_curve", s.density_curve},
          {"convention", s.convention},
          {"frames", s.frames},
          {"segments", s.segments},
          {"method", s.method},
          {"equations", s.equations},
          {"work_grid_mm", s.work_grid_mm},
          {"table_tolerance", s.table_tolerance},
          {"tolerance", s.tolerance},
          {"step", s.step ? json(*s.step) : json()},
          {"mesh_tolerance_mm", s.mesh_tolerance_mm},
          {"deface", s.deface},
          {"allow_untrusted", s.untrusted_is_fine},
          {"leap",
           {{"flight_time", s.leap.flight_time},
            {"somersault_rate_deg", s.leap.somersault_rate_deg},
            {"tuck", s.leap.tuck},
            {"muscle_frequency", s.leap.muscle_frequency},
            {"damping_ratio", s.leap.damping_ratio}}}};
}

// The settings of one stage, by name, so that a change of one reruns no more than what depends on it.
json pick(const json& all, std::initializer_list<const char*> names) {
  json some = json::object();
  for (const char* name : names) some[name] = all.at(name);
  return some;
}

std::vector<Stage> stages_of(Run& run, const RunSettings& settings) {
  const json all = settings_of(settings);
  const auto mute = [](auto method, Run& of) {
    return [method, &of](const Progress&, const json&) { return (of.*method)(); };
  };
  const auto shown = [](auto method, Run& of) {
    return [method, &of](const Progress& progress, const json&) { return (of.*method)(progress); };
  };
  std::vector<std::string> labelled{"segmentation/labels.nii.gz", "segmentation/labels.tsv",
                                    "segmentation/labels.ctbl", "segmentation/landmarks.json",
                                    "segmentation/segmentation.json"};
  if (!settings.segments.empty())
    labelled.insert(labelled.end(), {"segmentation/parts.nii.gz", "segmentation/parts.tsv"});
  std::vector<Stage> stages;
  stages.push_back(
      {"segmentation",
       {},
       pick(all, {"quantity", "work_grid_mm", "table_tolerance", "label_mapping", "convention", "segments"}),
       std::move(labelled),
       shown(settings.labels.empty() || !settings.label_mapping.empty() ? &Run::segment_scan
                                                                        : &Run::use_given_labels,
             run),
       {{"segmentation/landmarks.json"}}});
  stages.push_back({"inertia",
                    {"segmentation"},
                    pick(all, {"sex", "pose", "density_curve", "convention", "frames"}),
                    {"inertia/table.csv", "inertia/table.json"},
                    mute(&Run::integrate, run),
                    {{"inertia/table.csv", "inertia/table.json"}, {"inertia/table.json"}}});
  stages.push_back({"skeleton",
                    {"inertia"},
                    pick(all, {"subject", "leap", "method", "equations", "tolerance", "step"}),
                    {"model/scene.toml"},
                    mute(&Run::build_scene, run),
                    {{"model/scene.toml"}}});
  stages.push_back({"motion",
                    {"skeleton"},
                    pick(all, {"allow_untrusted"}),
                    {"motion/trajectory.h5", "motion/trajectory.csv"},
                    shown(&Run::move, run)});
  stages.push_back({"mesh",
                    {"segmentation"},
                    pick(all, {"mesh_tolerance_mm", "deface"}),
                    {},
                    shown(&Run::make_meshes, run)});
  stages.push_back({"glb", {"mesh", "motion"}, json::object(), {"body.glb"}, mute(&Run::make_glb, run)});
  stages.push_back({"picture", {"mesh"}, json::object(), {"body.png"}, mute(&Run::draw_picture, run)});
  stages.push_back({"report",
                    {"glb", "picture"},
                    json::object(),
                    {"report.html"},
                    [&run](const Progress&, const json& record) { return run.write_page(record); }});
  return stages;
}

}  // namespace

Result<json> run(const RunSettings& settings, bool force, const StageObserver& observer) {
  if (!settings.density_curve.empty())
    if (const auto curve = density_curve(settings.density_curve); !curve)
      return tl::unexpected(curve.error());
  const auto inputs = inputs_of(settings);
  if (!inputs) return tl::unexpected(inputs.error());
  const auto lock = FolderLock::take(settings.folder);
  if (!lock) return tl::unexpected(lock.error());
  if (auto fine = check_folder_writable(settings.folder / "mesh"); !fine) return tl::unexpected(fine.error());
  if (!settings.settings_text.empty())
    if (auto written = write_whole(settings.folder / "settings.toml", settings.settings_text); !written)
      return tl::unexpected(written.error());
  const auto digests = digests_of(*inputs);
  if (!digests) return tl::unexpected(digests.error());
  json head{
      {"program", "borelli " BORELLI_VERSION}, {"inputs", *digests}, {"settings", settings_of(settings)}};
  Run work(settings);
  return run_stages(*lock, head, stages_of(work, settings), force, observer);
}

}  // namespace borelli
