// borelli chart SCENE -o DIR: cost and error of each method on a scene.
#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "error/json_text.hpp"
#include "pipeline/charts/work_precision_page.hpp"
#include "pipeline/files/digest.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/names.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

constexpr const char* partial = "chart.partial.json";

struct ChartOptions {
  std::string scene, folder = "chart", reference;
  std::optional<double> reference_error;
  ModelOptions model;
  std::vector<std::string> equations = {"recursive", "lagrange"}, constraints = {"projection", "baumgarte"};
  std::optional<double> end;
  bool quick = false, thorough = false;
  WorkPrecisionSettings settings;
};

// Results of an interrupted run, which the same command resumes.
class KeptPoints {
 public:
  KeptPoints(std::filesystem::path file, const std::string& asked)
      : file_(std::move(file)), asked_(digest_of_bytes(asked)) {}

  std::vector<WorkPrecisionPoint> read() const {
    const auto text = read_input_file(file_);
    if (!text) return {};
    const auto kept = parse_json(*text, file_.string());
    if (!kept) return {};
    try {
      return points_of(*kept);
    } catch (const nlohmann::json::exception&) {  // damaged: everything is run again
      return {};
    }
  }

  Result<void> write(const std::vector<WorkPrecisionPoint>& points) const {
    nlohmann::json all = nlohmann::json::array();  // non-finite numbers become null
    for (const WorkPrecisionPoint& p : points)
      all.push_back({p.variant, p.setting, p.finished, p.trusted, p.reason, p.seconds, p.evaluations,
                     p.errors.position, p.errors.orientation, p.errors.energy, p.errors.constraint,
                     p.errors.impacts, p.errors.momentum});
    return write_whole(file_, json_text(nlohmann::json{{"asked", asked_}, {"points", all}}, -1));
  }

  void remove() const {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }

 private:
  std::vector<WorkPrecisionPoint> points_of(const nlohmann::json& kept) const {
    std::vector<WorkPrecisionPoint> out;
    if (kept.at("asked") != asked_) return out;  // from another chart
    const auto number = [](const nlohmann::json& x) {
      return x.is_null() ? std::numeric_limits<double>::quiet_NaN() : x.get<double>();
    };
    for (const auto& p : kept.at("points"))
      out.push_back({p.at(0),
                     p.at(1),
                     p.at(2),
                     p.at(3),
                     p.at(4),
                     p.at(5),
                     p.at(6),
                     {number(p.at(7)), number(p.at(8)), number(p.at(9)), number(p.at(10)), number(p.at(11)),
                      number(p.at(12))}});
    return out;
  }

  std::filesystem::path file_;
  std::string asked_;
};

nlohmann::json json_of(const WorkPrecision& chart) {
  nlohmann::json take = nlohmann::json::array();
  for (const auto& [digits, p] : recommendations(chart))
    take.push_back({{"error", std::pow(10., -digits)},
                    {"method", name_of(chart.variants[p->variant])},
                    {"setting", p->setting},
                    {"seconds", p->seconds},
                    {"evaluations", p->evaluations}});
  return {{"scene", chart.scene},
          {"reference",
           {{"found", chart.reference.found},
            {"runs", chart.reference.runs},
            {"position", chart.reference.position},
            {"orientation", chart.reference.orientation},
            {"horizon", chart.reference.horizon}}},
          {"runs", chart.points.size()},
          {"take", take}};
}

WorkPrecisionSettings chart_settings(const ChartOptions& o) {
  WorkPrecisionSettings settings = o.settings;
  settings.equations.clear();
  for (const std::string& name : o.equations)
    settings.equations.push_back(name == "lagrange" ? Equations::lagrange : Equations::recursive);
  settings.constraints.clear();
  for (const std::string& name : o.constraints)
    settings.constraints.push_back(name == "baumgarte" ? ConstraintTreatment::baumgarte
                                                       : ConstraintTreatment::projection);
  return settings;
}

// Reads the reference trajectory, if given, into the settings. Returns a text that identifies it; else "".
Result<std::string> use_reference(const ChartOptions& o, const Scene& scene,
                                  WorkPrecisionSettings& settings) {
  if (o.reference.empty()) {
    if (o.reference_error)
      return bad_use("--reference-error", "applies only to the file of --reference; give both, or neither");
    return std::string();
  }
  std::vector<std::string> solids;
  for (const Solid& solid : scene.solids) solids.push_back(solid.name);
  auto given = read_reference(o.reference, solids);
  if (!given) return tl::unexpected(given.error());
  given->error = o.reference_error.value_or(given->error);
  const auto bytes = read_input_file(o.reference);  // its contents, since the file may be rewritten
  if (!bytes) return tl::unexpected(bytes.error());
  settings.reference = std::move(*given);
  return fmt::format(" {} {} {}", o.reference, settings.reference->error, digest_of_bytes(*bytes));
}

// All that the results depend on, besides the reference.
Result<std::string> what_is_asked(const ChartOptions& o, const Scene& scene,
                                  const WorkPrecisionSettings& settings) {
  const auto text = write_scene(scene);
  if (!text) return text;
  std::string asked = *text + BORELLI_VERSION;
  for (const auto* names : {&o.settings.methods, &o.equations, &o.constraints})
    for (const std::string& name : *names) asked += ' ' + name;
  asked +=
      fmt::format(" {} {} {} {}", settings.outputs, settings.repeats, settings.per_decade, settings.budget);
  return asked;
}

// Runs the methods. Keeps the points of finished ones, and writes the page after each round.
Result<WorkPrecision> run_methods(const Scene& scene, const WorkPrecisionSettings& settings,
                                  const std::filesystem::path& folder, const KeptPoints& kept,
                                  const Command& command) {
  ProgressBar bar(command.json);
  bar.begin("chart");
  WorkPrecisionObserver observer;
  constexpr const char* stopped =
      "\nborelli: stopped; the same command continues after the last finished method\n";
  observer.known = kept.read();
  if (!observer.known.empty()) say_when_stopped(stopped);
  observer.progress = [&](const std::string&, double fraction) { bar.update(fraction); };
  observer.ladder_ends = [&](const std::vector<WorkPrecisionPoint>& points) {
    say_when_stopped(stopped);
    return kept.write(points);
  };
  observer.round_ends = [&](const WorkPrecision& coarse) {
    if (auto done = write_work_precision(coarse, folder, command.warnings_in_files()); !done) return done;
    bar.end(fmt::format("{} runs in {}; finer ones follow", coarse.points.size(),
                        (folder / "chart.html").string()));
    bar.begin("chart");
    return Result<void>();
  };
  auto chart = work_precision(scene, settings, observer);
  if (!chart) return chart;
  bar.end(fmt::format("{} runs", chart->points.size()));
  return chart;
}

void print_chart(const WorkPrecision& chart, const std::string& page) {
  fmt::print("{}\n", chart.reference.words);
  for (const auto& [digits, p] : recommendations(chart))
    fmt::print("  for 1e-{:02}  {:32} {:9} {:<9.3g} {:9.3f} ms {:9} evaluations\n", digits,
               name_of(chart.variants[p->variant]), setting_name(chart.variants[p->variant]), p->setting,
               1e3 * p->seconds, p->evaluations);
  const std::string why = why_no_drawing(chart);
  if (why.empty())
    fmt::print("{}: page with the drawings; SVG, PNG and CSV files are beside it\n", page);
  else
    fmt::print("{} {}: page with the table; the CSV file is beside it\n", why, page);
}

Result<nlohmann::json> work(const ChartOptions& o, const Command& command) {
  const std::filesystem::path folder = o.folder;
  std::vector<std::string> files = work_precision_files();
  files.emplace_back(partial);
  if (auto fine = check_folder_writable(folder, files); !fine) return tl::unexpected(fine.error());
  auto model = read_model_for_pages(command, o.scene, o.model);
  if (!model) return tl::unexpected(model.error());
  Scene& scene = model->scene;
  scene.simulation.end_time = o.end.value_or(scene.simulation.end_time);
  WorkPrecisionSettings settings = chart_settings(o);
  const auto asked = what_is_asked(o, scene, settings);
  if (!asked) return tl::unexpected(asked.error());
  const auto reference = use_reference(o, scene, settings);
  if (!reference) return tl::unexpected(reference.error());
  const KeptPoints kept(folder / partial, *asked + *reference);
  const auto chart = run_methods(scene, settings, folder, kept, command);
  if (!chart) return tl::unexpected(chart.error());
  if (auto done = write_work_precision(*chart, folder, command.warnings_in_files()); !done)
    return tl::unexpected(done.error());
  kept.remove();
  say_when_stopped(nullptr);
  if (!command.json) print_chart(*chart, (folder / "chart.html").string());
  return json_of(*chart);
}

}  // namespace

void add_chart(CLI::App& program, Command& command) {
  std::vector<std::string> methods = integrator_names();
  methods.emplace_back(automatic);
  auto* verb = program.add_subcommand(
      "chart",
      "Run a scene with every method and draw the error against the computing time (work-precision chart)");
  auto o = std::make_shared<ChartOptions>();
  verb->add_option("scene", o->scene, "Scene file: TOML, MJCF, URDF or OpenSim")->required();
  add_output(*verb, o->folder, "FOLDER", "Folder for the page, the drawings and the table")
      ->capture_default_str();
  auto* quick = verb->add_flag("--quick", o->quick, "Coarse chart: --budget 0.02 --repeats 1");
  verb->add_flag("--thorough", o->thorough, "Fine chart: --budget 2 --repeats 5 --per-decade 2")
      ->excludes(quick);
  add_shared(*verb, flags::methods, o->settings.methods,
             "; `auto` chooses one as simulate --accuracy does (default: all)")
      ->delimiter(',')
      ->check(one_of(methods));
  add_shared(*verb, flags::end, o->end);
  add_shared(*verb, flags::equations, o->equations, "; both, separated by commas, are compared")
      ->delimiter(',')
      ->capture_default_str();
  add_shared(*verb, flags::constraints, o->constraints, "; both, separated by commas, are compared")
      ->delimiter(',')
      ->capture_default_str();
  add_shared(*verb, flags::samples, o->settings.outputs)->capture_default_str();
  verb->add_option("--repeats", o->settings.repeats, "Runs per point; the reported time is their median")
      ->check(whole_number_within(1, 1000))
      ->capture_default_str();
  verb->add_option("--per-decade", o->settings.per_decade, "Tolerances per decade for adaptive methods")
      ->check(whole_number_within(1, 10))
      ->capture_default_str();
  verb->add_option(
          "--budget", o->settings.budget,
          "Processor time per run, s; a method gets no finer setting after its first run that takes longer")
      ->check(number_within(1e-5, 1e6))  // less than the shortest run would give an empty chart
      ->capture_default_str();
  verb->add_option("--reference", o->reference,
                   "Reference motion that is more accurate than any run, for example a closed form: a CSV or "
                   "HDF5 file as simulate writes it, with one row per output time")
      ->type_name("FILE");
  verb->add_option(
          "--reference-error", o->reference_error,
          "Error of the reference: positions relative to the scene's length, angles in rad (default: 1e-12)")
      ->check(positive_number());
  group_options(*verb, "Runs",
                {"--equations", "--constraints", "--samples", "--repeats", "--per-decade", "--budget"});
  group_options(*verb, "Reference", {"--reference", "--reference-error"});
  add_model_options(*verb, o->model);
  verb->callback([&command, o, verb] {
    const auto preset = [&](const char* option, auto& value, auto number) {
      if (verb->count(option) == 0) value = number;
    };
    if (o->quick || o->thorough) {
      preset("--budget", o->settings.budget, o->quick ? 0.02 : 2);
      preset("--repeats", o->settings.repeats, o->quick ? 1 : 5);
      preset("--per-decade", o->settings.per_decade, o->quick ? 1 : 2);
    }
    for (auto* names : {&o->settings.methods, &o->equations, &o->constraints}) *names = each_once(*names);
    command.work = [o](const Command& c) { return work(*o, c); };
  });
}

}  // namespace borelli
