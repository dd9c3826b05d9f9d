// borelli run: from a volume to a moving body and its report.
#include "pipeline/stages/run.hpp"
#include "pipeline/body/measure.hpp"
#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/files/digest.hpp"
#include "pipeline/files/input_names.hpp"
#include "pipeline/stages/run_captured.hpp"

#include <fmt/core.h>

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "dynamics/methods/integrator.hpp"
#include "pipeline/verbs/number_check.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/settings.hpp"
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
  std::string out, quantity, table_tolerance, tolerance;
  VideoAsked video;
  bool work_grid_chosen = false, integrator_tolerance_chosen = false;
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
  std::string words = "borelli run VOLUME --settings settings.toml --out FOLDER";
  for (const char* option : {"volume", "--out"}) verb.get_option(option)->configurable(false);
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
      if (given) return bad_use(option, "belongs to a captured motion; give --motion");
    return {};
  }
  if (holds_angles(captured))
    for (const auto& [option, given] : {std::pair{"--static", !captured.trial.empty()},
                                        {"--marker-map", !captured.marker_map.empty()},
                                        {"--calibrate-markers", captured.calibrate},
                                        {"--bvh-unit", captured.bvh_unit > 0}})
      if (given)
        return bad_use(option,
                       "is about markers, and " + captured.motion + " holds joint angles; leave it out");
  if (captured.recorded_mass > 0 && !captured.other_person)
    return bad_use("--recorded-mass", "is of another person than the scanned one; give --other-person");
  if (settings.model_tolerance > 0)
    return bad_use("--tolerance",
                   "chooses the smallest model for a simulated motion; leave it or --motion out");
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

Result<nlohmann::json> work(RunAsked asked, const Command& command) {
  RunSettings& settings = asked.run;
  if (!asked.quantity.empty()) {
    const auto quantity = parse_quantity(asked.quantity);
    if (!quantity) return tl::unexpected(quantity.error());
    settings.quantity = *quantity;
  }
  if (settings.labels.empty() && !settings.label_names.empty())
    return bad_use("--label-names", "names the labels of the map in --labels; give both, or neither");
  if (settings.labels.empty() && !settings.label_mapping.empty())
    return bad_use("--label-mapping", "maps the classes of the map in --labels; give both, or neither");
  if (!settings.labels.empty() && settings.label_mapping.empty() && asked.work_grid_chosen)
    return bad_use("--work-grid",
                   "has no effect with --labels, which gives the parts; leave one of the two out");
  if (settings.labels.empty() || !settings.label_mapping.empty())
    if (const auto known = convention(settings.convention); !known)
      return bad_use(
          "--convention " + settings.convention,
          "applies only to --labels that were cut by it; to find parts, choose deleva1996, dempster or bone");
  if (settings.labels.empty() || !settings.label_mapping.empty())
    if (const auto segments = choose_segments(settings.segments); !segments)
      return tl::unexpected(segments.error());
  if (const auto absent = parse_absent(settings.absent); !absent) return tl::unexpected(absent.error());
  if (!settings.absent.empty() && !settings.labels.empty() && settings.label_mapping.empty())
    return bad_use("--absent",
                   "has no effect with --labels, which gives the parts; leave one of the two out");
  if (!asked.table_tolerance.empty()) {
    if (asked.work_grid_chosen)
      return bad_use("--table-tolerance", "chooses the work grid itself; leave it or --work-grid out");
    if (!settings.labels.empty() && settings.label_mapping.empty())
      return bad_use("--table-tolerance",
                     "has no effect with --labels, which gives the parts; leave one of the two out");
    const auto tolerance = parse_tolerance(asked.table_tolerance);
    if (!tolerance) return tl::unexpected(tolerance.error());
    settings.table_tolerance = *tolerance;
  }
  if (!asked.tolerance.empty()) {
    const auto tolerance = parse_tolerance(asked.tolerance);
    if (!tolerance)
      return bad_use("--tolerance " + asked.tolerance,
                     "is not a tolerance from 0.1 to 50 %; write 1% or 0.01 (the integrator's tolerance is "
                     "--integrator-tolerance)");
    settings.model_tolerance = *tolerance;
    const bool parts_given = !settings.labels.empty() && settings.label_mapping.empty();
    if (asked.table_tolerance.empty() && !asked.work_grid_chosen && !parts_given)
      settings.table_tolerance = *tolerance;
  }
  if (!settings.motion_quantities.empty() && asked.tolerance.empty())
    return bad_use("--keep", "says what must stay within --tolerance; give both, or neither");
  if (asked.integrator_tolerance_chosen && !settings.method.empty() && !method_is_adaptive(settings.method))
    return bad_use("--integrator-tolerance", "has no effect with " + settings.method +
                                                 ", whose steps have a fixed length; give --step");
  if (auto fine = check_captured(settings); !fine) return tl::unexpected(fine.error());
  if (settings.skin && settings.deface) return bad_use("--skin", "keeps the face; leave it or --deface out");
  if (!asked.video.file.empty()) {
    if (fs::path(asked.video.file).has_parent_path())
      return bad_use("--video " + asked.video.file, "names a file in the run's folder; leave folders out");
    auto options = video_options(asked.video);
    if (!options) return tl::unexpected(options.error());
    settings.video = asked.video.file;
    settings.video_options = *options;
  }
  if (settings.subject.empty()) {
    auto name = name_of_input(settings.volume, settings.keep_paths);
    if (!name) return tl::unexpected(name.error());
    settings.subject = std::move(*name);
  }
  if (settings.subject.find('/') != std::string::npos || settings.subject.starts_with('.'))
    return bad_use("--subject " + settings.subject,
                   "is not a folder name; it must not contain '/' or begin with '.'");
  settings.folder = fs::path(asked.out) / settings.subject;
  settings.threads = command.threads;
  if (lies_within(settings.folder, settings.volume))
    return bad_use(
        settings.folder.string(),
        fmt::format("lies within the scan's folder {}; name another folder with --out", settings.volume));

  std::optional<ProgressBar> bar(std::in_place, command.json);
  StageObserver observer;
  std::set<std::string> at_work;
  observer.begins = [&](const Stage& stage) {
    at_work.insert(stage.name);
    bar->begin(stage.name);
  };
  observer.progress = [&](const Stage& stage, double share) { bar->update(share, stage.name); };
  observer.ends = [&](const Stage& stage, double seconds) {
    at_work.erase(stage.name);
    bar->end(fmt::format("{:.2f} s", seconds), stage.name);
  };
  observer.fails = [&](const Stage& stage, const Error& error) {
    const bool begun = at_work.erase(stage.name) > 0;
    if (at_work.empty()) return;  // no other stage can run for long now: reported at the end
    if (!begun) bar->begin(stage.name);
    bar->end("failed: " + error.message(), stage.name);
  };
  observer.skipped = [&](const Stage& stage) {
    bar->begin(stage.name);
    bar->end("already done", stage.name);
  };
  std::vector<std::string> warnings;
  observer.warns = [&](const Stage& stage, const std::string& warning) {
    warnings.push_back(stage.name + ": " + warning);
  };
  const auto record = run(settings, command.force, observer);
  bar.reset();
  if (!record) {  // the warnings may explain it
    command.warn(warnings);
    return record;
  }
  for (const auto& stage : (*record)["stages"])
    for (const auto& note : stage.value("notes", nlohmann::json::array()))
      command.note(stage["stage"].get<std::string>() + ": " + note.get<std::string>());
  for (const auto& stage : (*record)["stages"])
    for (const auto& warning : stage.value("warnings", nlohmann::json::array()))
      command.warn(stage["stage"].get<std::string>() + ": " + warning.get<std::string>());
  if (!command.json) print_outcome(*record, settings.folder);
  return record;
}

}  // namespace

void add_run(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("run", "Turn a volume into a moving body and its report");
  auto asked = std::make_shared<RunAsked>();
  RunSettings& s = asked->run;
  verb->add_option("volume", s.volume, "Volume: a DICOM folder or a file (.nii.gz, .nrrd, .mha)")->required();
  verb->add_option("-o,--out", asked->out, "Folder for the results; they go to <out>/<subject>")->required();
  verb->add_option(
      "--subject", s.subject,
      "Name of the subject (default: the file's name; for a folder, a name made from its contents)");
  verb->add_option(
      "--quantity", asked->quantity,
      "What the voxels hold: hu, density_kgm3, density_gcm3 or mr (default: taken from the file)");
  verb->add_option("--labels", s.labels, "Label map on the volume's grid; replaces the segmentation");
  verb->add_option("--label-names", s.label_names,
                   "Names of the labels, a TSV file (default: the file of names beside the label map)");
  verb->add_option("--label-mapping", s.label_mapping, label_mapping_help);
  verb->add_option(
      "--landmarks", s.landmarks,
      "Landmarks placed by hand (JSON, or .mrk.json and .fcsv of 3D Slicer); they replace those found");
  verb->add_option("--absent", s.absent, absent_help);
  verb->add_option("--sex", s.sex,
                   "male or female; shows published values for comparison (default: from DICOM)")
      ->check(CLI::IsMember({"male", "female"}));
  verb->add_option("--pose", s.pose, "How the person lay or stood, e.g. supine (default: from DICOM)");
  verb->add_option("--stature", s.stature_m,
                   "Body height from sole to vertex, m; group tables (inertia --compare) need it")
      ->check(positive_number());
  verb->add_option("--density-curve", s.density_curve, "Curve from CT numbers to densities, by name");
  verb->add_option("--convention", s.convention,
                   "How parts are cut: deleva1996, dempster or bone; with --labels, how those were cut")
      ->check(CLI::IsMember(cut_names))
      ->capture_default_str();
  verb->add_option("--frames", s.frames,
                   "Axes of the segments: joints (along the joint centres) or isb (as the ISB defines them)")
      ->check(CLI::IsMember({"joints", "isb"}))
      ->capture_default_str();
  verb->add_option("--segments", s.segments, segments_help);
  verb->add_option("--work-grid", s.work_grid_mm, "Spacing of the grid on which parts are found, mm")
      ->check(number_within(finest_step, coarsest_step))
      ->capture_default_str();
  verb->add_option(
      "--table-tolerance", asked->table_tolerance,
      "Choose the coarsest work grid that keeps every entry of the inertia table within this error, e.g. 1%");
  verb->add_option("--accuracy", s.accuracy,
                   "Largest error of positions and velocities, relative to their scales; chooses the "
                   "integrator and its tolerance")
      ->check(number_within(1e-11, 0.1))
      ->capture_default_str();
  verb->add_option("--method", s.method, "Integrator (default: chosen from --accuracy)")
      ->check(CLI::IsMember(integrator_names()))
      ->excludes("--accuracy");
  verb->add_option("--equations", s.equations,
                   "Equations of motion: recursive (along the tree) or lagrange (the paper's scan)")
      ->check(CLI::IsMember({"recursive", "lagrange"}))
      ->capture_default_str();
  verb->add_option("--tolerance", asked->tolerance,
                   "Largest error of the answers, e.g. 5%: chooses the smallest model whose motion stays "
                   "within it (see economy), and the work grid as --table-tolerance does");
  verb->add_option(
          "--keep", s.motion_quantities,
          "What of the motion must stay within --tolerance: centre, solid:NAME, solid:NAME:x,y,z, turn:NAME "
          "or coordinate:NAME; may be repeated (default: the gravity centres of all solids)")
      ->allow_extra_args(false);
  verb->add_option("--integrator-tolerance", s.integrator_tolerance,
                   "With --method: its largest error per step and coordinate")
      ->check(positive_number())
      ->needs("--method")
      ->capture_default_str();
  verb->add_option("--step", s.step, "With --method: its fixed step, or the first step of an adaptive one, s")
      ->check(positive_number())
      ->needs("--method");
  verb->add_option("--mesh-tolerance", s.mesh_tolerance_mm,
                   "How far mesh simplification may move the surface, mm")
      ->check(number_not_negative())
      ->capture_default_str();
  CapturedSettings& c = s.captured;
  verb->add_option("--motion", c.motion,
                   "Captured motion: markers (.trc, .c3d), a skeleton (.bvh) or joint angles (.mot, .sto; "
                   "the body's own or "
                   "OpenSim's coordinates); the body moves so instead of leaping");
  verb->add_option(
      "--forces", c.forces,
      "Its ground forces: .mot, .sto, OpenSim's external loads (.xml) or .c3d (default: those of a "
      ".c3d motion)");
  verb->add_option(
      "--static", c.trial,
      "The same person standing still (.trc, .c3d); places the markers (default: a frame of the motion)");
  verb->add_option(
      "--marker-map", c.marker_map,
      "Lines 'MARKER = PLACE' for markers whose names are not of a common set; a place is a landmark or "
      "a part, e.g. knee_lateral_left or thigh_left");
  verb->add_flag(
      "--other-person", c.other_person,
      "The recorded person is not the scanned one: scale motion and forces to the body, set its feet down");
  verb->add_flag("--calibrate-markers", c.calibrate,
                 "Place the markers where the motion shows them on average, not where the trial alone does");
  verb->add_option("--recorded-mass", c.recorded_mass,
                   "Mass of the other person, kg (default: as the forces tell)")
      ->check(positive_number());
  verb->add_option("--cut-off", c.cutoff, "Cut-off of the low-pass filter over the joint angles, Hz; 0: none")
      ->check(number_not_negative())
      ->capture_default_str();
  verb->add_option("--band-draws", c.band_draws,
                   "Draws for each cause of error behind the moments' error bands; 0: no bands")
      ->check(number_within(0, 10000))
      ->capture_default_str();
  verb->add_option("--bvh-unit", c.bvh_unit, "Metres of a BVH file's unit (default: guessed from its size)")
      ->check(positive_number());
  verb->add_option("--flight-time", s.leap.flight_time, "Flight time of the leap, s")
      ->check(number_within(0.05, 10.0))
      ->capture_default_str();
  verb->add_option("--somersault-rate", s.leap.somersault_rate_deg,
                   "Somersault rate at take-off, deg/s; negative is backwards")
      ->check(number_within(-3600, 3600))
      ->capture_default_str();
  verb->add_option("--tuck", s.leap.tuck, "How far the joint springs pull towards a tuck, from 0 to 1")
      ->check(number_within(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--muscle-frequency", s.leap.muscle_frequency,
                   "Natural frequency of the passive joints, Hz")
      ->check(number_within(0.0, 20.0))
      ->capture_default_str();
  verb->add_option("--damping-ratio", s.leap.damping_ratio, "Damping ratio of the passive joints")
      ->check(number_within(0.0, 10.0))
      ->capture_default_str();
  verb->add_flag("--skin", s.skin, "Also write skin.glb: one closed skin that bends with the body");
  add_video_options(*verb, asked->video, "in the run's folder");
  verb->add_flag("--deface", s.deface,
                 "Remove the face from meshes, picture and report (the labels keep it)");
  verb->add_flag("--keep-paths", s.keep_paths, keep_paths_help);
  verb->add_flag("--allow-untrusted", s.untrusted_is_fine,
                 "Continue with a motion that its certificate does not trust");
  group_options(*verb, "Labels and landmarks",
                {"--labels", "--label-names", "--label-mapping", "--landmarks"});
  group_options(*verb, "Inertia table",
                {"--density-curve", "--convention", "--frames", "--segments", "--stature", "--work-grid",
                 "--table-tolerance"});
  group_options(
      *verb, "Leap",
      {"--flight-time", "--somersault-rate", "--tuck", "--muscle-frequency", "--damping-ratio", "--tolerance",
       "--keep", "--accuracy", "--method", "--equations", "--integrator-tolerance", "--step"});
  group_options(*verb, "Captured motion",
                {"--motion", "--forces", "--static", "--marker-map", "--calibrate-markers", "--other-person",
                 "--recorded-mass", "--cut-off", "--band-draws", "--bvh-unit"});
  group_options(*verb, "Results",
                {"--mesh-tolerance", "--skin", "--deface", "--keep-paths", "--allow-untrusted"});
  verb->callback([&command, asked, verb] {
    asked->work_grid_chosen = verb->count("--work-grid") > 0;
    asked->integrator_tolerance_chosen = verb->count("--integrator-tolerance") > 0;
    // settings without effect are not stored, so that the stored settings can be run again:
    const bool named = !asked->run.method.empty();
    if (named) verb->get_option("--accuracy")->configurable(false);
    if (!named || !method_is_adaptive(asked->run.method))
      verb->get_option("--integrator-tolerance")->configurable(false);
    // with given labels no grid is used to find parts: the stored settings contain none and can be run again
    const bool picked =
        !asked->table_tolerance.empty() || (!asked->tolerance.empty() && !asked->work_grid_chosen);
    if ((!asked->run.labels.empty() && asked->run.label_mapping.empty()) || picked)
      verb->get_option("--work-grid")->configurable(false);
    asked->run.settings_text =
        asked->run.keep_paths ? settings_text(*verb) : settings_without_paths(*verb, asked->run);
    command.work = [asked](const Command& chosen) { return work(*asked, chosen); };
  });
}

}  // namespace borelli
