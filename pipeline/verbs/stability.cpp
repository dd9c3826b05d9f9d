// borelli stability SCENE... -o DIR: where methods fail on a scene, over steps and over a number of the
// scene.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "error/json_text.hpp"
#include "pipeline/charts/long_runs.hpp"
#include "pipeline/charts/picture.hpp"
#include "pipeline/charts/stability_page.hpp"
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

constexpr const char* unfinished_map = "stability.partial.json";

struct StabilityOptions {
  std::vector<std::string> scenes, methods;
  std::string folder = "stability", vary, steps, tolerances, equations = "recursive";
  ModelOptions model;
  std::optional<std::string> constraints;
  std::optional<double> end;
  std::optional<long> long_steps;
  RunLengths lengths;
  bool failing = false;
};

Result<Scene> read(const StabilityOptions& o, const std::string& file, const Command& command) {
  auto model = read_model_for_pages(command, file, o.model);
  if (!model) return tl::unexpected(model.error());
  model->scene.simulation.end_time = o.end.value_or(model->scene.simulation.end_time);
  return std::move(model->scene);
}

/// Splits "a,b=1:10" into the paths a and b and the text after the sign.
Result<std::pair<std::vector<std::string>, std::string>> parse_vary(const std::string& text) {
  const std::size_t sign = text.rfind('=');
  if (sign == std::string::npos || sign == 0)
    return bad_use("--vary",
                   fmt::format("is '{}', expected PATH=LOW:HIGH, such as spring.stiffness=1:1e8", text));
  std::vector<std::string> paths(1);
  for (const char c : text.substr(0, sign))
    if (c == ',')
      paths.emplace_back();
    else
      paths.back() += c;
  return std::pair(paths, text.substr(sign + 1));
}

Result<Sweep> sweep_of(const StabilityOptions& o, const Command& command) {
  if (o.vary.empty()) {
    std::vector<Scene> scenes;
    for (const std::string& file : o.scenes) {
      auto scene = read(o, file, command);
      if (!scene) return tl::unexpected(scene.error());
      scenes.push_back(std::move(*scene));
    }
    return sweep_of_scenes(std::move(scenes), o.scenes);
  }
  if (o.scenes.size() > 1)
    return bad_use("--vary", "applies to a single scene; name one scene, or leave out --vary");
  const auto vary = parse_vary(o.vary);
  if (!vary) return tl::unexpected(vary.error());
  const auto values = parse_ladder(vary->second, "--vary");
  if (!values) return tl::unexpected(values.error());
  auto scene = read(o, o.scenes[0], command);
  if (!scene) return tl::unexpected(scene.error());
  // paths refer to the file; a model of another format is first converted to a scene
  auto text = read_input_file(o.scenes[0]);
  if (text && !parse_scene(*text, o.scenes[0])) text = write_scene(*scene);
  if (!text) return tl::unexpected(text.error());
  auto sweep = sweep_of_number(*text, command.names().name_of(o.scenes[0]), vary->first, *values);
  if (sweep)
    for (Result<Scene>& one : sweep->scenes)
      if (one && o.end) one->simulation.end_time = *o.end;
  return sweep;
}

nlohmann::json number(double x) {
  return std::isnan(x) ? nlohmann::json() : std::isinf(x) ? nlohmann::json("all") : nlohmann::json(x);
}

nlohmann::json json_of(const StabilityMap& map) {
  nlohmann::json limits = nlohmann::json::array();
  for (const StabilityLimit& limit : map.limits)
    limits.push_back({{"method", map.methods[limit.method]},
                      {"parameter", map.sweep.values.values[limit.column]},
                      {"name", map.sweep.names[limit.column]},
                      {"stable", limit.known ? number(limit.stable) : nlohmann::json("not known")},
                      {"unseen", limit.unseen > 0 ? nlohmann::json(limit.unseen) : nlohmann::json()},
                      {"over_s", limit.over > 0 ? nlohmann::json(limit.over) : nlohmann::json()},
                      {"linear", limit.linear ? number(*limit.linear) : nlohmann::json()},
                      {"trusted", number(limit.trusted)}});
  return {{"scene", map.sweep.scene},
          {"parameter", map.sweep.parameter},
          {"runs", map.cells.size()},
          {"limits", limits}};
}

void print(const StabilityMap& map) {
  fmt::print("  {:20} {:28} {:>18} {:>12} {:>12}\n", "method",
             map.sweep.parameter.empty() ? "scene" : map.sweep.parameter, "stable up to", "linear",
             "trusted up to");
  for (const StabilityLimit& limit : map.limits)
    fmt::print("  {:20} {:28} {:>18} {:>12} {:>12}\n", map.methods[limit.method],
               map.sweep.parameter.empty() ? map.sweep.names[limit.column]
                                           : fmt::format("{:.6g}", map.sweep.values.values[limit.column]),
               stable_words(map, limit), limit.linear ? limit_words(*limit.linear) : "-",
               limit_words(limit.trusted));
  if (const std::string growing = own_growth_words(map); !growing.empty()) fmt::print("  {}\n", growing);
}

// Results of an interrupted map, which the same command resumes.
class KeptColumns {
 public:
  /// `asked`: everything that the runs depend on.
  KeptColumns(std::filesystem::path file, const std::string& asked)
      : file_(std::move(file)), asked_(digest_of_bytes(asked)) {}

  void read(StabilityObserver& observer) const {
    const auto text = read_input_file(file_);
    if (!text) return;
    const auto kept = parse_json(*text, file_.string());
    if (!kept) return;
    try {
      take(*kept, observer);
    } catch (const nlohmann::json::exception&) {  // damaged: everything is run again
    }
  }

  Result<void> write(const StabilityMap& map) const {
    nlohmann::json cells = nlohmann::json::array(), limits = nlohmann::json::array();
    for (const StabilityCell& c : map.cells)
      cells.push_back({c.method, c.column, c.setting, int(c.tried.outcome), c.tried.reason, c.tried.end,
                       c.tried.steps, c.tried.evaluations, number(c.tried.energy),
                       number(c.tried.constraint)});
    for (const StabilityLimit& l : map.limits) {
      nlohmann::json linear = nlohmann::json::array();
      if (l.linear) linear.push_back(number(*l.linear));
      limits.push_back(
          {l.method, l.column, number(l.stable), number(l.trusted), linear, l.over, l.unseen, l.known});
    }
    return write_whole(
        file_, json_text(nlohmann::json{{"asked", asked_}, {"cells", cells}, {"limits", limits}}, -1));
  }

  void remove() const {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }

 private:
  void take(const nlohmann::json& kept, StabilityObserver& observer) const {
    if (kept.at("asked") != asked_) return;  // from another map
    const auto limit = [](const nlohmann::json& x) {
      return x.is_null()     ? std::numeric_limits<double>::quiet_NaN()
             : x.is_string() ? std::numeric_limits<double>::infinity()
                             : x.get<double>();
    };
    std::vector<StabilityCell> cells;
    std::vector<StabilityLimit> limits;
    for (const auto& c : kept.at("cells"))
      cells.push_back({c.at(0),
                       c.at(1),
                       c.at(2),
                       {.outcome = Outcome(c.at(3).get<int>()),
                        .reason = c.at(4),
                        .end = c.at(5),
                        .steps = c.at(6),
                        .evaluations = c.at(7),
                        .energy = limit(c.at(8)),
                        .constraint = limit(c.at(9))}});
    for (const auto& l : kept.at("limits")) {
      limits.push_back({l.at(0), l.at(1), limit(l.at(2)), limit(l.at(3))});
      if (!l.at(4).empty()) limits.back().linear = limit(l.at(4).at(0));
      limits.back().over = l.at(5);
      limits.back().unseen = l.at(6);
      limits.back().known = l.at(7);
    }
    observer.known_cells = std::move(cells), observer.known_limits = std::move(limits);
  }

  std::filesystem::path file_;
  std::string asked_;
};

/// Everything that a map's runs depend on.
std::string asked_for(const StabilityOptions& o, const Sweep& sweep) {
  std::string out = BORELLI_VERSION;
  for (const std::string* one : {&o.steps, &o.tolerances, &o.equations}) out += ' ' + *one + ';';
  out += fmt::format("{} {} {};", o.constraints.value_or(""), o.lengths.least, o.lengths.most);
  for (const std::string& method : o.methods) out += ' ' + method;
  for (const Result<Scene>& scene : sweep.scenes) {
    const auto text = scene ? write_scene(*scene) : tl::unexpected(scene.error());
    out += '\n' + (text ? *text : text.error().message());
  }
  return out;
}

/// Names of all drawings that a map may have.
std::vector<std::string> map_drawings() {
  std::vector<std::string> out = integrator_names();
  out.insert(out.end(), {"limits", "limits_tolerance", "methods", "methods_tolerance"});
  return out;
}

/// Checks that all outputs can be written.
Result<void> check_outputs(const StabilityOptions& o) {
  std::vector<std::string> files;
  if (o.long_steps) {
    files = plot_files(long_run_plot_names());
    for (const std::string& name : long_run_plot_names()) files.push_back(name + ".csv");
    files.insert(files.end(), {"long.csv", "long.html"});
  } else {
    files = plot_files(map_drawings());
    files.insert(files.end(), {"stability.csv", "limits.csv", "stability.html", unfinished_map});
  }
  const std::filesystem::path folder = o.folder;
  auto fine = check_folder_writable(folder, files);
  return fine && o.failing ? check_folder_writable(folder / "failing") : fine;
}

Result<nlohmann::json> work_on_map(const StabilityOptions& o, const Command& command) {
  const std::filesystem::path folder = o.folder;
  StabilitySettings settings;
  settings.methods = o.methods;
  settings.equations = o.equations == "lagrange" ? Equations::lagrange : Equations::recursive;
  if (o.constraints)
    settings.constraints =
        *o.constraints == "baumgarte" ? ConstraintTreatment::baumgarte : ConstraintTreatment::projection;
  settings.lengths = o.lengths;
  settings.lengths.least = std::min(settings.lengths.least, settings.lengths.most);
  for (const auto& [text, what, ladder] : {std::tuple(&o.steps, "--steps", &settings.steps),
                                           std::tuple(&o.tolerances, "--tolerances", &settings.tolerances)}) {
    if (text->empty()) continue;
    const bool of_adaptive = ladder == &settings.tolerances;
    if (!o.methods.empty() && std::ranges::none_of(o.methods, [&](const std::string& method) {
          return method_is_adaptive(method) == of_adaptive;
        }))
      return bad_use(what, of_adaptive ? "has no effect, since all methods have fixed steps; give --steps"
                                       : "has no effect, since all methods are adaptive; give --tolerances");
    auto parsed = parse_ladder(*text, what);
    if (!parsed) return tl::unexpected(parsed.error());
    *ladder = std::move(*parsed);
  }
  auto sweep = sweep_of(o, command);
  if (!sweep) return tl::unexpected(sweep.error());
  ProgressBar bar(command.json);
  bar.begin("stability");
  const KeptColumns kept(folder / unfinished_map, asked_for(o, *sweep));
  StabilityObserver observer;
  constexpr const char* stopped =
      "\nborelli: stopped; the same command continues after the last finished column\n";
  kept.read(observer);
  if (!observer.known_limits.empty()) say_when_stopped(stopped);
  observer.progress = [&](double fraction) { bar.update(fraction); };
  observer.column_ends = [&](const StabilityMap& so_far) {
    say_when_stopped(stopped);
    return kept.write(so_far);
  };
  const auto map = stability_map(std::move(*sweep), settings, observer);
  if (!map) return tl::unexpected(map.error());
  bar.end(fmt::format("{} runs", map->cells.size()));
  if (auto done = write_plots(stability_plots(*map), folder, map_drawings()); !done)
    return tl::unexpected(done.error());
  for (const auto& [name, text] :
       {std::pair("stability.csv", stability_csv(*map)), std::pair("limits.csv", stability_limits_csv(*map)),
        std::pair("stability.html", stability_page(*map, command.warnings_in_files()))})
    if (auto done = write_whole(folder / name, text); !done) return tl::unexpected(done.error());
  kept.remove();
  say_when_stopped(nullptr);
  if (o.failing)
    for (const auto& [name, text] : failing_scenes(*map, settings))
      if (auto done = write_whole(folder / "failing" / name, text); !done)
        return tl::unexpected(done.error());
  if (!command.json) {
    print(*map);
    fmt::print("{}: page with the maps; SVG, PNG and CSV files are beside it\n",
               (folder / "stability.html").string());
  }
  return json_of(*map);
}

Result<nlohmann::json> work_on_long_runs(const StabilityOptions& o, const Command& command) {
  const std::filesystem::path folder = o.folder;
  if (o.scenes.size() > 1 || !o.vary.empty())
    return bad_use("--long", "runs a single, unchanged scene; name one scene and leave out --vary");
  LongRunSettings settings;
  settings.methods = o.methods;
  settings.equations = o.equations == "lagrange" ? Equations::lagrange : Equations::recursive;
  settings.steps = *o.long_steps;
  for (const auto& [text, what, value] : {std::tuple(&o.steps, "--steps", &settings.step),
                                          std::tuple(&o.tolerances, "--tolerances", &settings.tolerance)}) {
    if (text->empty()) continue;
    const auto parsed = parse_ladder(*text, what);
    if (!parsed) return tl::unexpected(parsed.error());
    if (parsed->values.size() > 1 || !(parsed->values[0] > 0))
      return bad_use(what, fmt::format("is '{}'; long runs need one positive number", *text));
    *value = parsed->values[0];
  }
  auto scene = read(o, o.scenes[0], command);
  if (!scene) return tl::unexpected(scene.error());
  if (o.constraints)
    scene->simulation.constraints =
        *o.constraints == "baumgarte" ? ConstraintTreatment::baumgarte : ConstraintTreatment::projection;
  ProgressBar bar(command.json);
  bar.begin("long runs");
  const auto runs = long_runs(*scene, settings, [&](double fraction) { bar.update(fraction); });
  if (!runs) return tl::unexpected(runs.error());
  bar.end(fmt::format("{} methods", runs->runs.size()));
  const auto plots = long_run_plots(*runs);
  if (auto done = write_plots(plots, folder); !done) return tl::unexpected(done.error());
  for (const auto& [name, plot] : plots)
    if (auto done = write_whole(folder / (name + ".csv"), csv(plot)); !done)
      return tl::unexpected(done.error());
  for (const auto& [name, text] :
       {std::pair("long.csv", long_runs_csv(*runs)),
        std::pair("long.html", long_runs_page(*runs, command.warnings_in_files()))})
    if (auto done = write_whole(folder / name, text); !done) return tl::unexpected(done.error());
  nlohmann::json all = nlohmann::json::array();
  for (const LongRun& run : runs->runs) {
    all.push_back({{"method", run.method},
                   {"finished", run.reason.empty()},
                   {"reason", run.reason},
                   {"secular", run.secular},
                   {"drift_per_s", run.drift},
                   {"swing", run.swing},
                   {"evaluations", run.evaluations}});
    if (!command.json)
      fmt::print("  {:20} {}\n", run.method,
                 run.energy.empty()
                     ? run.reason
                     : fmt::format("{} {:10.2g} 1/s, swing {:10.2g}{}{}",
                                   run.secular   ? run.drift > 0 ? "gains steadily " : "loses steadily "
                                   : run.large() ? "off by more than a tenth, drift"
                                                 : "bounded, drift",
                                   run.drift, run.swing, run.reason.empty() ? "" : "; ", run.reason));
  }
  if (!command.json)
    fmt::print("{}: page with the runs; SVG, PNG and CSV files are beside it\n",
               (folder / "long.html").string());
  return nlohmann::json{{"scene", runs->scene}, {"step", runs->step}, {"end", runs->end}, {"runs", all}};
}

}  // namespace

void add_stability(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand(
      "stability", "Map where methods fail on a scene, over the step and over one number of the scene");
  auto o = std::make_shared<StabilityOptions>();
  verb->add_option("scenes", o->scenes,
                   "Scene file: TOML, MJCF, URDF or OpenSim; several scenes become the map's columns")
      ->required();
  add_output(*verb, o->folder, "FOLDER", "Folder for the page, the drawings and the tables")
      ->capture_default_str();
  verb->add_option("--vary", o->vary,
                   "Number of the scene's file to vary, PATH=LOW:HIGH[:COUNT], such as "
                   "spring.stiffness=1:1e8; several paths separated by commas take the same value")
      ->type_name("PATH=RANGE");
  add_shared(*verb, flags::methods, o->methods, " (default: all)")
      ->delimiter(',')
      ->check(one_of(integrator_names()));
  add_shared(*verb, flags::end, o->end);
  verb->add_option("--steps", o->steps,
                   "Steps of methods with a fixed step, LOW:HIGH[:COUNT], s; with --long a single value")
      ->type_name("RANGE");
  verb->add_option("--tolerances", o->tolerances,
                   "Tolerances of adaptive methods, LOW:HIGH[:COUNT]; with --long a single value")
      ->type_name("RANGE");
  add_shared(*verb, flags::equations, o->equations)->capture_default_str();
  add_shared(*verb, flags::constraints, o->constraints, " (default: the scene's)");
  verb->add_option("--most-steps", o->lengths.most,
                   "Largest number of steps per run, even before its end time")
      ->check(whole_number_within(8, 1000000000))
      ->capture_default_str();
  auto* failing = verb->add_flag("--failing", o->failing,
                                 "Write the scenes on which a method failed closest to its limit");
  verb->add_option("--long", o->long_steps,
                   "Instead of a map: measure the drift of energy and momentum over this many steps")
      ->check(whole_number_within(8, 10000000))
      ->excludes(failing);
  group_options(*verb, "Methods",
                {"--steps", "--tolerances", "--equations", "--constraints", "--most-steps"});
  group_options(*verb, "Other results", {"--failing", "--long"});
  add_model_options(*verb, o->model);
  verb->callback([&command, o] {
    o->methods = each_once(o->methods);
    command.work = [o](const Command& c) -> Result<nlohmann::json> {
      if (auto fine = check_outputs(*o); !fine) return tl::unexpected(fine.error());
      return o->long_steps ? work_on_long_runs(*o, c) : work_on_map(*o, c);
    };
  });
}

}  // namespace borelli
