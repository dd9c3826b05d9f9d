// borelli run: from a volume to a moving body and its report.
#include "pipeline/stages/run.hpp"
#include "pipeline/body/measure.hpp"
#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/files/digest.hpp"
#include "pipeline/files/input_names.hpp"
#include "pipeline/stages/run_captured.hpp"

#include <fmt/core.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "dynamics/methods/integrator.hpp"
#include "error/file_ending.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/settings.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "pipeline/verbs/video_options.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/volume_formats.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

struct RunAsked {
  RunSettings run;
  std::string out, quantity, table_tolerance, model_tolerance;
  VideoAsked video;
  bool work_grid_chosen = false, tolerance_chosen = false;
  std::string without_effect;  ///< an option of the other kind of motion: leap or captured
};

// The default name of the subject: the file's name without its extensions. A folder's name is often the
// patient's. So for a folder the name is a digest of the first file's bytes and of all files' names and
// sizes.
Result<std::string> name_of_input(const std::string& path, bool keep_paths) {
  std::error_code problem;
  fs::path name = fs::path(path).filename();
  if (name.empty()) name = fs::path(path).parent_path().filename();
  if (!keep_paths && fs::is_directory(path, problem)) {
    std::map<fs::path, std::uintmax_t> sizes;
    for (fs::recursive_directory_iterator entry(path, problem), end; !problem && entry != end;
         entry.increment(problem))
      if (entry->is_regular_file(problem)) sizes.emplace(entry->path(), entry->file_size(problem));
    if (sizes.empty()) return "scan";
    const auto first = digest_of(sizes.begin()->first);
    if (!first) return tl::unexpected(first.error());
    std::string files = *first;
    for (const auto& [file, size] : sizes)
      files += fmt::format("\n{} {}", file.lexically_relative(path).string(), size);
    return "scan-" + digest_of_bytes(files).substr(0, 8);
  }
  std::string text = name.string();
  for (const Endings endings : {&VolumeFormat::endings, &VolumeFormat::halves})
    text.resize(text.size() - format_of(text, endings).ending.size());
  return text.empty() || text == "." || text == ".." ? "subject" : text;
}

// The text of settings.toml without paths, since it is shared with the results; its first lines give the
// command that repeats the run.
std::string settings_without_paths(CLI::App& verb, const RunSettings& s) {
  std::error_code problem;
  const bool own_mapping = fs::exists(s.label_mapping, problem);
  std::string words = "borelli run VOLUME --settings settings.toml --output FOLDER";
  for (const char* option : {"volume", "--output"}) verb.get_option(option)->configurable(false);
  for (const auto& [option, given] : {std::pair{"--labels", s.labels},
                                      {"--label-names", s.label_names},
                                      {"--label-mapping", own_mapping ? s.label_mapping : ""},
                                      {"--landmarks", s.landmarks},
                                      {"--motion", s.captured.motion},
                                      {"--forces", s.captured.forces},
                                      {"--static", s.captured.trial},
                                      {"--marker-map", s.captured.marker_map}}) {
    if (given.empty()) continue;
    verb.get_option(option)->configurable(false);
    words += fmt::format(" {} {}", option, fs::path(given).filename().string());
  }
  return "# Paths of inputs are left out (--keep-paths keeps them). To repeat the run:\n#   " + words + "\n" +
         settings_text(verb);
}

// whether output there would be among the files of a scan's folder
bool lies_within(const fs::path& path, const fs::path& folder) {
  std::error_code problem;
  if (!fs::is_directory(folder, problem)) return false;
  const fs::path whole = fs::weakly_canonical(folder, problem);
  for (fs::path at = fs::weakly_canonical(fs::absolute(path), problem);; at = at.parent_path()) {
    if (at == whole) return true;
    if (at == at.parent_path()) return false;
  }
}

// Whether the options of a captured motion go together.
Result<void> check_captured(const RunSettings& settings) {
  const CapturedSettings& captured = settings.captured;
  if (captured.motion.empty()) {
    for (const auto& [option, given] : {std::pair{"--forces", !captured.forces.empty()},
                                        {"--static", !captured.trial.empty()},
                                        {"--marker-map", !captured.marker_map.empty()},
                                        {"--calibrate-markers", captured.calibrate},
                                        {"--other-person", captured.other_person}})
      if (given) return bad_use(option, "applies only to a recorded motion; add --motion FILE");
    return {};
  }
  if (holds_angles(captured))
    for (const auto& [option, given] : {std::pair{"--static", !captured.trial.empty()},
                                        {"--marker-map", !captured.marker_map.empty()},
                                        {"--calibrate-markers", captured.calibrate},
                                        {"--bvh-unit", captured.bvh_unit > 0}})
      if (given)
        return bad_use(option, "applies only to markers, and " + captured.motion +
                                   " contains joint angles; leave it out");
  if (captured.bvh_unit > 0 && ending_of(captured.motion) != ".bvh" && ending_of(captured.trial) != ".bvh")
    return bad_use("--bvh-unit", "applies only to recordings in .bvh; leave it out");
  if (captured.recorded_mass > 0 && !captured.other_person)
    return bad_use("--recorded-mass", "applies only with --other-person; add that, or leave it out");
  if (settings.model_tolerance > 0)
    return bad_use("--model-tolerance",
                   "applies only to a simulated motion; leave out --model-tolerance or --motion");
  return {};
}

void print_outcome(const nlohmann::json& record, const fs::path& folder) {
  for (const auto& stage : record["stages"])
    if (stage.contains("tolerance") && stage["tolerance"].value("met", false))
      fmt::print("{}\n", stage["tolerance"].value("in_words", ""));
  for (const auto& stage : record["stages"])
    if (stage.contains("economy")) fmt::print("{}\n", stage["economy"].value("in_words", ""));
  for (const auto& stage : record["stages"])
    if (stage.contains("mass_kg") && !stage.contains("by_hand"))
      fmt::print("mass {:.3f} kg; ", stage["mass_kg"].get<double>());
  fmt::print("report: {}\n", (folder / "report.html").string());
}

// Whether the labels are parts that replace the segmentation.
bool parts_given(const RunSettings& settings) {
  return !settings.labels.empty() && settings.label_mapping.empty();
}

// Whether the options of the labels and of the segmentation go together.
Result<void> check_labels(const RunAsked& asked) {
  const RunSettings& settings = asked.run;
  if (settings.labels.empty() && !settings.label_names.empty())
    return bad_use("--label-names", "applies only with --labels; give both, or neither");
  if (settings.labels.empty() && !settings.label_mapping.empty())
    return bad_use("--label-mapping", "applies only with --labels; give both, or neither");
  if (parts_given(settings) && asked.work_grid_chosen)
    return bad_use("--work-grid",
                   "has no effect with --labels, which gives the parts; leave one of the two out");
  if (!parts_given(settings)) {
    if (const auto known = convention(settings.convention); !known)
      return bad_use(
          "--convention " + settings.convention,
          "applies only to --labels that were cut by it; to find parts, choose deleva1996, dempster or bone");
    if (const auto segments = choose_segments(settings.segments); !segments)
      return tl::unexpected(segments.error());
  }
  if (const auto absent = parse_absent(settings.absent); !absent) return tl::unexpected(absent.error());
  if (!settings.absent.empty() && parts_given(settings))
    return bad_use("--absent",
                   "has no effect with --labels, which gives the parts; leave one of the two out");
  return {};
}

// Puts the wanted tolerances of table and motion into the settings.
Result<void> use_tolerances(RunAsked& asked) {
  RunSettings& settings = asked.run;
  if (!asked.table_tolerance.empty()) {
    if (asked.work_grid_chosen)
      return bad_use("--table-tolerance",
                     "chooses the work grid itself; leave out --table-tolerance or --work-grid");
    if (parts_given(settings))
      return bad_use("--table-tolerance",
                     "has no effect with --labels, which gives the parts; leave one of the two out");
    const auto tolerance = parse_tolerance(asked.table_tolerance);
    if (!tolerance) return tl::unexpected(tolerance.error());
    settings.table_tolerance = *tolerance;
  }
  if (!asked.model_tolerance.empty()) {
    const auto tolerance = parse_tolerance(asked.model_tolerance);
    if (!tolerance) return tl::unexpected(tolerance.error());
    settings.model_tolerance = *tolerance;
    if (asked.table_tolerance.empty() && !asked.work_grid_chosen && !parts_given(settings))
      settings.table_tolerance = *tolerance;
  }
  return {};
}

// Whether the options of the motion go together.
Result<void> check_motion(const RunAsked& asked) {
  const RunSettings& settings = asked.run;
  if (!settings.motion_quantities.empty() && asked.model_tolerance.empty())
    return bad_use("--keep", "applies only with --model-tolerance; give both, or neither");
  if (asked.tolerance_chosen && !settings.method.empty() && !method_is_adaptive(settings.method))
    return bad_use("--tolerance", "has no effect with " + settings.method +
                                      ", whose steps have a fixed length; give --step");
  if (!asked.without_effect.empty())
    return bad_use(asked.without_effect, settings.captured.motion.empty()
                                             ? "applies only to a recorded motion; add --motion FILE"
                                             : "shapes the leap, which --motion replaces; leave it out");
  return check_captured(settings);
}

Result<void> use_video(const VideoAsked& video, RunSettings& settings) {
  if (video.file.empty()) return {};
  if (fs::path(video.file).has_parent_path())
    return bad_use("--video " + video.file,
                   "must be a file name without folders; the video goes to the run's folder");
  auto options = video_options(video);
  if (!options) return tl::unexpected(options.error());
  settings.video = video.file;
  settings.video_options = *options;
  return {};
}

// Names the subject, if the user does not, and the run's folder in the folder `out`.
Result<void> name_folder(const std::string& out, RunSettings& settings) {
  if (settings.subject.empty()) {
    auto name = name_of_input(settings.volume, settings.keep_paths);
    if (!name) return tl::unexpected(name.error());
    settings.subject = std::move(*name);
  }
  if (settings.subject.find('/') != std::string::npos || settings.subject.starts_with('.'))
    return bad_use("--subject " + settings.subject,
                   "is not a folder name; it must not contain '/' or begin with '.'");
  settings.folder = fs::path(out) / settings.subject;
  if (lies_within(settings.folder, settings.volume))
    return bad_use(
        settings.folder.string(),
        fmt::format("lies within the scan's folder {}; name another folder with --output", settings.volume));
  return {};
}

// Shows the stages of a run as they begin, go on and end.
class ShownStages {
 public:
  explicit ShownStages(bool quiet) : bar_(quiet) {}

  StageObserver observer() {
    StageObserver out;
    out.begins = [this](const Stage& stage) {
      at_work_.insert(stage.name);
      bar_.begin(stage.name);
    };
    out.progress = [this](const Stage& stage, double share) { bar_.update(share, stage.name); };
    out.ends = [this](const Stage& stage, double seconds) {
      at_work_.erase(stage.name);
      bar_.end(fmt::format("{:.2f} s", seconds), stage.name);
    };
    out.fails = [this](const Stage& stage, const Error& error) {
      const bool begun = at_work_.erase(stage.name) > 0;
      if (at_work_.empty()) return;  // no other stage can run for long now: reported at the end
      if (!begun) bar_.begin(stage.name);
      bar_.end("failed: " + error.message(), stage.name);
    };
    out.skipped = [this](const Stage& stage) {
      bar_.begin(stage.name);
      bar_.end("already done", stage.name);
    };
    out.warns = [this](const Stage& stage, const std::string& warning) {
      warnings_.push_back(stage.name + ": " + warning);
    };
    return out;
  }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  ProgressBar bar_;
  std::set<std::string> at_work_;
  std::vector<std::string> warnings_;
};

Result<nlohmann::json> run_shown(const RunSettings& settings, const Command& command) {
  std::optional<ShownStages> shown(std::in_place, command.json);
  const auto record = run(settings, command.force, shown->observer());
  const std::vector<std::string> warnings = shown->warnings();
  shown.reset();                        // ends the progress bar
  if (!record) command.warn(warnings);  // they may explain it
  return record;
}

Result<nlohmann::json> work(RunAsked asked, const Command& command) {
  RunSettings& settings = asked.run;
  if (!asked.quantity.empty()) {
    const auto quantity = parse_quantity(asked.quantity);
    if (!quantity) return tl::unexpected(quantity.error());
    settings.quantity = *quantity;
  }
  if (auto fine = check_labels(asked); !fine) return tl::unexpected(fine.error());
  if (auto fine = use_tolerances(asked); !fine) return tl::unexpected(fine.error());
  if (auto fine = check_motion(asked); !fine) return tl::unexpected(fine.error());
  if (settings.skin && settings.deface)
    return bad_use("--skin", "writes the face, which --deface removes; leave one of the two out");
  if (auto fine = check_effect(asked.video); !fine) return tl::unexpected(fine.error());
  if (auto fine = use_video(asked.video, settings); !fine) return tl::unexpected(fine.error());
  if (auto fine = name_folder(asked.out, settings); !fine) return tl::unexpected(fine.error());
  settings.threads = command.threads;

  const auto record = run_shown(settings, command);
  if (!record) return record;
  for (const auto& stage : (*record)["stages"])
    for (const auto& note : stage.value("notes", nlohmann::json::array()))
      command.note(stage["stage"].get<std::string>() + ": " + note.get<std::string>());
  for (const auto& stage : (*record)["stages"])
    for (const auto& warning : stage.value("warnings", nlohmann::json::array()))
      command.warn(stage["stage"].get<std::string>() + ": " + warning.get<std::string>());
  if (!command.json) print_outcome(*record, settings.folder);
  return record;
}

void add_scan_flags(CLI::App& verb, RunAsked& asked) {
  RunSettings& s = asked.run;
  add_shared(verb, flags::subject, s.subject,
             " (default: the file's name; for a folder, a name made from its contents)");
  add_shared(verb, flags::quantity, asked.quantity, flags::quantity_default);
  add_shared(verb, flags::sex, s.sex, flags::sex_compares);
  add_shared(verb, flags::pose, s.pose);
  add_shared(verb, flags::absent, s.absent);
  add_shared(verb, flags::landmarks, s.landmarks, flags::landmarks_win);
  add_shared(
      verb, flags::labels, s.labels,
      "; it holds parts, which replace the segmentation, or with --label-mapping the classes of another "
      "program, which help to find the parts");
  add_shared(verb, flags::label_mapping, s.label_mapping);
  add_shared(verb, flags::label_names, s.label_names);
  group_options(verb, "Labels of another program", {"--labels", "--label-mapping", "--label-names"});
}

void add_table_flags(CLI::App& verb, RunAsked& asked) {
  RunSettings& s = asked.run;
  add_shared(verb, flags::convention, s.convention,
             ": deleva1996, dempster or bone; with --labels, how those were cut")
      ->check(one_of(cut_names))
      ->capture_default_str();
  add_shared(verb, flags::segments, s.segments);
  add_shared(verb, flags::work_grid, s.work_grid_mm)->capture_default_str();
  add_shared(verb, flags::table_tolerance, asked.table_tolerance,
             "; chooses the coarsest work grid that keeps it");
  add_shared(verb, flags::density_curve, s.density_curve,
             fmt::format(" (default: {})", default_density_curve));
  add_shared(verb, flags::frames, s.frames)->capture_default_str();
  add_shared(verb, flags::stature, s.stature_m, "; group tables (inertia --compare) need it");
  group_options(verb, "Inertia table",
                {"--convention", "--segments", "--work-grid", "--table-tolerance", "--density-curve",
                 "--frames", "--stature"});
}

void add_captured_flags(CLI::App& verb, CapturedSettings& c) {
  add_shared(
      verb, flags::motion, c.motion,
      ", which the body makes instead of leaping: markers (.trc, .c3d), a skeleton (.bvh) or joint angles "
      "(.mot, .sto; the body's own or OpenSim's coordinates)");
  add_shared(verb, flags::forces, c.forces, " (default: those of a .c3d motion)");
  add_shared(verb, flags::standing, c.trial, "; places the markers (default: a frame of the motion)");
  verb.add_option(
          "--marker-map", c.marker_map,
          "Lines 'MARKER = PLACE' for markers whose names are not of a common set; a place is a landmark or "
          "a part, e.g. knee_lateral_left or thigh_left")
      ->type_name("FILE");
  verb.add_flag("--calibrate-markers", c.calibrate,
                "Place the markers where the motion shows them on average, not where the trial alone does");
  verb.add_flag(
      "--other-person", c.other_person,
      "The recorded person is not the scanned one: scale motion and forces to the body, set its feet down");
  verb.add_option("--recorded-mass", c.recorded_mass,
                  "Mass of the other person, kg (default: from the forces)")
      ->check(positive_number());
  add_shared(verb, flags::cut_off, c.cutoff)->capture_default_str();
  verb.add_option("--band-draws", c.band_draws,
                  "Draws for each cause of error behind the moments' error bands; 0: no bands")
      ->check(number_within(0, 10000))
      ->capture_default_str();
  add_shared(verb, flags::bvh_unit, c.bvh_unit);
  group_options(verb, "Captured motion",
                {"--motion", "--forces", "--static", "--marker-map", "--calibrate-markers", "--other-person",
                 "--recorded-mass", "--cut-off", "--band-draws", "--bvh-unit"});
}

void add_leap_flags(CLI::App& verb, RunAsked& asked) {
  RunSettings& s = asked.run;
  verb.add_option("--flight-time", s.leap.flight_time, "Flight time of the leap, s")
      ->check(number_within(0.05, 10.0))
      ->capture_default_str();
  verb.add_option("--somersault-rate", s.leap.somersault_rate_deg,
                  "Somersault rate at take-off, deg/s; negative is backwards")
      ->check(number_within(-3600, 3600))
      ->capture_default_str();
  verb.add_option("--tuck", s.leap.tuck, "How far the joint springs pull towards a tuck")
      ->check(number_within(0.0, 1.0))
      ->capture_default_str();
  verb.add_option("--muscle-frequency", s.leap.muscle_frequency,
                  "Natural frequency of the passive joints, Hz")
      ->check(number_within(0.0, 20.0))
      ->capture_default_str();
  verb.add_option("--damping-ratio", s.leap.damping_ratio, "Damping ratio of the passive joints")
      ->check(number_within(0.0, 10.0))
      ->capture_default_str();
  auto* accuracy = add_shared(verb, flags::accuracy, s.accuracy)->capture_default_str();
  add_shared(verb, flags::model_tolerance, asked.model_tolerance,
             "; chooses the work grid too, as --table-tolerance does");
  add_shared(verb, flags::keep, s.motion_quantities)->allow_extra_args(false);
  auto* method = add_shared(verb, flags::method, s.method, " (default: chosen from --accuracy)");
  method->excludes(accuracy);
  add_shared(verb, flags::equations, s.equations)->capture_default_str();
  add_shared(verb, flags::tolerance, s.integrator_tolerance)->needs(method)->capture_default_str();
  add_shared(verb, flags::step, s.step)->needs(method);
  group_options(
      verb, "Leap",
      {"--flight-time", "--somersault-rate", "--tuck", "--muscle-frequency", "--damping-ratio", "--accuracy",
       "--model-tolerance", "--keep", "--method", "--equations", "--tolerance", "--step"});
}

// Whether an option is left out or has its default value, as text or as a number. Settings that an earlier
// version stored contain every option.
bool has_default(const CLI::Option& option) {
  if (option.count() == 0) return true;
  const std::string given = option.as<std::string>(), usual = option.get_default_str();
  if (given == usual) return true;
  char* end = nullptr;
  const double number = std::strtod(given.c_str(), &end);
  return end != given.c_str() && *end == 0 && !usual.empty() && number == std::atof(usual.c_str());
}

void add_result_flags(CLI::App& verb, RunAsked& asked) {
  RunSettings& s = asked.run;
  verb.add_flag("--skin", s.skin, "Also write skin.glb: one closed skin that bends with the body");
  add_shared(verb, flags::deface, s.deface, "; the labels keep it");
  add_shared(verb, flags::mesh_tolerance, s.mesh_tolerance_mm)->capture_default_str();
  add_shared(verb, flags::keep_paths, s.keep_paths);
  add_shared(verb, flags::allow_untrusted, s.untrusted_is_fine);
  group_options(verb, "Results",
                {"--skin", "--deface", "--mesh-tolerance-mm", "--keep-paths", "--allow-untrusted"});
  add_video_options(verb, asked.video, "it goes to the run's folder");
}

}  // namespace

void add_run(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("run", "Turn a volume into a moving body and its report");
  auto asked = std::make_shared<RunAsked>();
  verb->add_option("volume", asked->run.volume, flags::volume.meaning)->required();
  add_output(*verb, asked->out, "FOLDER", "Folder for the results; they go to <output>/<subject>")
      ->required();
  add_scan_flags(*verb, *asked);
  add_table_flags(*verb, *asked);
  add_captured_flags(*verb, asked->run.captured);
  add_leap_flags(*verb, *asked);
  add_result_flags(*verb, *asked);
  verb->callback([&command, asked, verb] {
    asked->work_grid_chosen = verb->count("--work-grid") > 0;
    asked->tolerance_chosen = verb->count("--tolerance") > 0;
    const bool captured = !asked->run.captured.motion.empty();
    for (const char* option : captured ? std::vector{"--flight-time", "--somersault-rate", "--tuck",
                                                     "--muscle-frequency", "--damping-ratio", "--accuracy",
                                                     "--method", "--equations", "--tolerance", "--step"}
                                       : std::vector{"--cut-off", "--band-draws", "--bvh-unit"}) {
      if (!has_default(*verb->get_option(option))) asked->without_effect = option;
      verb->get_option(option)->configurable(false);
    }
    // settings without effect are not stored, so that the stored settings can be run again:
    const bool named = !asked->run.method.empty();
    if (named) verb->get_option("--accuracy")->configurable(false);
    if (!named || !method_is_adaptive(asked->run.method))
      verb->get_option("--tolerance")->configurable(false);
    // with given labels no grid is used to find parts: the stored settings contain none and can be run again
    const bool picked =
        !asked->table_tolerance.empty() || (!asked->model_tolerance.empty() && !asked->work_grid_chosen);
    if (parts_given(asked->run) || picked) verb->get_option("--work-grid")->configurable(false);
    asked->run.settings_text =
        asked->run.keep_paths ? settings_text(*verb) : settings_without_paths(*verb, asked->run);
    command.work = [asked](const Command& chosen) { return work(*asked, chosen); };
  });
}

}  // namespace borelli
