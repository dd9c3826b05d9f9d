// borelli run: from a volume to a moving body and its report.
#include "pipeline/stages/run.hpp"
#include "pipeline/body/measure.hpp"
#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/files/digest.hpp"
#include "pipeline/files/input_names.hpp"

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
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

struct RunAsked {
  RunSettings run;
  std::string out, quantity, table_tolerance, tolerance;
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
  for (const char* ending : {".gz", ".nii", ".hdr", ".img", ".nrrd", ".nhdr", ".mha", ".mhd"})
    if (text.ends_with(ending) && text.size() > std::string(ending).size())
      text.resize(text.size() - std::string(ending).size());
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
                                      {"--landmarks", s.landmarks}}) {
    if (given.empty()) continue;
    verb.get_option(option)->configurable(false);
    words += fmt::format(" {} {}", option, fs::path(given).filename().string());
  }
  return "# Paths of inputs are left out (--keep-paths keeps them). To run it again:\n#   " + words + "\n" +
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
    return bad_use("--label-names", "names the labels of a map that --labels gives: give both, or neither");
  if (settings.labels.empty() && !settings.label_mapping.empty())
    return bad_use("--label-mapping", "maps the classes of a map that --labels gives: give both, or neither");
  if (!settings.labels.empty() && settings.label_mapping.empty() && asked.work_grid_chosen)
    return bad_use("--work-grid", "is for finding parts, and --labels gives them: leave one of the two out");
  if (settings.labels.empty() || !settings.label_mapping.empty())
    if (const auto known = convention(settings.convention); !known)
      return bad_use(
          "--convention " + settings.convention,
          "is of labels that were cut so (--labels); parts are found by deleva1996, dempster or bone");
  if (settings.labels.empty() || !settings.label_mapping.empty())
    if (const auto segments = choose_segments(settings.segments); !segments)
      return tl::unexpected(segments.error());
  if (const auto absent = parse_absent(settings.absent); !absent) return tl::unexpected(absent.error());
  if (!settings.absent.empty() && !settings.labels.empty() && settings.label_mapping.empty())
    return bad_use("--absent", "is for finding parts, and --labels gives them: leave one of the two out");
  if (!asked.table_tolerance.empty()) {
    if (asked.work_grid_chosen)
      return bad_use("--table-tolerance", "picks the work grid: leave one of it and --work-grid out");
    if (!settings.labels.empty() && settings.label_mapping.empty())
      return bad_use("--table-tolerance",
                     "picks the grid for finding parts, and --labels gives them: leave one of the two out");
    const auto tolerance = parse_tolerance(asked.table_tolerance);
    if (!tolerance) return tl::unexpected(tolerance.error());
    settings.table_tolerance = *tolerance;
  }
  if (!asked.tolerance.empty()) {
    const auto tolerance = parse_tolerance(asked.tolerance);
    if (!tolerance)
      return bad_use("--tolerance " + asked.tolerance,
                     "give how far answers may be off, from 0.1 to 50 %, as 1% or 0.01 (the integrator's own "
                     "is --integrator-tolerance)");
    settings.model_tolerance = *tolerance;
    const bool parts_given = !settings.labels.empty() && settings.label_mapping.empty();
    if (asked.table_tolerance.empty() && !asked.work_grid_chosen && !parts_given)
      settings.table_tolerance = *tolerance;
  }
  if (!settings.motion_quantities.empty() && asked.tolerance.empty())
    return bad_use("--keep", "says what is to stay within --tolerance: give both, or neither");
  if (asked.integrator_tolerance_chosen && !method_is_adaptive(settings.method))
    return bad_use("--integrator-tolerance", "has no effect with " + settings.method +
                                                 ", whose steps are all of one length: give --step");
  if (settings.subject.empty()) {
    auto name = name_of_input(settings.volume, settings.keep_paths);
    if (!name) return tl::unexpected(name.error());
    settings.subject = std::move(*name);
  }
  if (settings.subject.find('/') != std::string::npos || settings.subject.starts_with('.'))
    return bad_use("--subject " + settings.subject, "names a folder; it may not hold '/' nor begin with '.'");
  settings.folder = fs::path(asked.out) / settings.subject;
  settings.threads = command.threads;
  if (lies_within(settings.folder, settings.volume))
    return bad_use(settings.folder.string(),
                   fmt::format("lies within {}, of whose files the scan is made: name another folder with "
                               "--out",
                               settings.volume));

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
    bar->end("done before", stage.name);
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
  auto* verb = program.add_subcommand("run", "From a volume to a moving body and its report");
  auto asked = std::make_shared<RunAsked>();
  RunSettings& s = asked->run;
  verb->add_option("volume", s.volume, "A DICOM folder or a volume file (.nii.gz, .nrrd, .mha)")->required();
  verb->add_option("-o,--out", asked->out, "Folder; the results go to <out>/<subject>")->required();
  verb->add_option("--subject", s.subject,
                   "Name of the subject (default: the file's name; of a folder, a name from its content)");
  verb->add_option("--quantity", asked->quantity, "What the voxels hold: hu, density_kgm3, density_gcm3, mr");
  verb->add_option("--labels", s.labels, "A label map on the volume's grid, to use instead of segmenting");
  verb->add_option("--label-names", s.label_names, "Its names (TSV; default: beside it)");
  verb->add_option("--label-mapping", s.label_mapping, label_mapping_help);
  verb->add_option(
      "--landmarks", s.landmarks,
      "Landmarks placed by hand (JSON, or .mrk.json and .fcsv of 3D Slicer): they override what is found");
  verb->add_option("--absent", s.absent, absent_help);
  verb->add_option("--sex", s.sex, "male or female: shows published values beside (default: as DICOM says)")
      ->check(CLI::IsMember({"male", "female"}));
  verb->add_option("--pose", s.pose, "How the person lay or stood, e.g. supine (default: as DICOM says)");
  verb->add_option("--stature", s.stature_m, "Sole to vertex, m: for group tables (inertia --compare)")
      ->check(positive_number());
  verb->add_option("--density-curve", s.density_curve, "From CT numbers to density, by name");
  verb->add_option("--convention", s.convention,
                   "How parts are cut: deleva1996, dempster or bone; of given --labels, how they were cut")
      ->check(CLI::IsMember(cut_names))
      ->capture_default_str();
  verb->add_option("--frames", s.frames,
                   "Axes of the segments: along the joint centres, or as the ISB has them")
      ->check(CLI::IsMember({"joints", "isb"}))
      ->capture_default_str();
  verb->add_option("--segments", s.segments, segments_help);
  verb->add_option("--work-grid", s.work_grid_mm, "Grid on which parts are looked for, mm")
      ->check(number_within(finest_step, coarsest_step))
      ->capture_default_str();
  verb->add_option("--table-tolerance", asked->table_tolerance,
                   "Pick the coarsest work grid that gives every entry of the table within this, e.g. 1%");
  verb->add_option("--method", s.method, "Integrator")
      ->check(CLI::IsMember(integrator_names()))
      ->capture_default_str();
  verb->add_option("--equations", s.equations, "Equations of motion: along the tree, or the paper's scan")
      ->check(CLI::IsMember({"recursive", "lagrange"}))
      ->capture_default_str();
  verb->add_option("--tolerance", asked->tolerance,
                   "How far answers may be off, e.g. 5%: the body moves as the smallest model that stays "
                   "within it (see economy), and the work grid is picked as by --table-tolerance");
  verb->add_option("--keep", s.motion_quantities,
                   "What of the motion is to stay within --tolerance: centre, solid:NAME, "
                   "solid:NAME:x,y,z, turn:NAME, coordinate:NAME; may be repeated (default: all solids' "
                   "gravity centres)")
      ->allow_extra_args(false);
  verb->add_option("--integrator-tolerance", s.integrator_tolerance, "Per step and coordinate")
      ->check(positive_number())
      ->capture_default_str();
  verb->add_option("--step", s.step, "Fixed step, or the first one tried, s")->check(positive_number());
  verb->add_option("--mesh-tolerance", s.mesh_tolerance_mm, "How far a mesh may be simplified, mm")
      ->check(number_not_negative())
      ->capture_default_str();
  verb->add_option("--flight-time", s.leap.flight_time, "Of the leap, s")
      ->check(number_within(0.05, 10.0))
      ->capture_default_str();
  verb->add_option("--somersault-rate", s.leap.somersault_rate_deg, "At take-off, deg/s; negative: backwards")
      ->check(number_within(-3600, 3600))
      ->capture_default_str();
  verb->add_option("--tuck", s.leap.tuck, "How far the joints spring towards a tuck, 0 to 1")
      ->check(number_within(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--muscle-frequency", s.leap.muscle_frequency,
                   "Natural frequency of the passive joints, Hz")
      ->check(number_within(0.0, 20.0))
      ->capture_default_str();
  verb->add_option("--damping-ratio", s.leap.damping_ratio, "Of the passive joints")
      ->check(number_within(0.0, 10.0))
      ->capture_default_str();
  verb->add_flag("--deface", s.deface,
                 "Take the face out of meshes, picture and report (not out of the labels)");
  verb->add_flag("--keep-paths", s.keep_paths, keep_paths_help);
  verb->add_flag("--allow-untrusted", s.untrusted_is_fine,
                 "Go on with a motion that its certificate does not trust");
  group_options(*verb, "Labels and landmarks",
                {"--labels", "--label-names", "--label-mapping", "--landmarks"});
  group_options(*verb, "Inertia table",
                {"--density-curve", "--convention", "--frames", "--segments", "--stature", "--work-grid",
                 "--table-tolerance"});
  group_options(*verb, "Motion",
                {"--flight-time", "--somersault-rate", "--tuck", "--muscle-frequency", "--damping-ratio",
                 "--tolerance", "--keep", "--method", "--equations", "--integrator-tolerance", "--step"});
  group_options(*verb, "Results", {"--mesh-tolerance", "--deface", "--keep-paths", "--allow-untrusted"});
  verb->callback([&command, asked, verb] {
    asked->work_grid_chosen = verb->count("--work-grid") > 0;
    asked->integrator_tolerance_chosen = verb->count("--integrator-tolerance") > 0;
    // settings without effect are not stored, so that the stored settings can be run again:
    if (!method_is_adaptive(asked->run.method))
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
