// borelli economy SCENE -o DIR: the smallest model of a scene whose motion stays within a tolerance.
#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "dynamics/model_file.hpp"
#include "dynamics/scene_file.hpp"
#include "pipeline/economy_page.hpp"
#include "pipeline/picture.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/number_check.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/verb.hpp"
#include "pipeline/whole_file.hpp"

namespace borelli {
namespace {

struct Options {
  std::string scene, folder = "economy";
  ModelOptions model;
  std::optional<double> end;
  EconomySettings settings;
};

nlohmann::json json_of(const Economy& economy) {
  nlohmann::json models = nlohmann::json::array(), stays = nlohmann::json::array();
  for (const EconomyModel& m : economy.models)
    models.push_back({{"change", m.change},
                      {"error", m.error},
                      {"worst", m.worst},
                      {"coordinates", m.coordinates},
                      {"bodies", m.bodies},
                      {"rows", m.rows},
                      {"evaluations", m.evaluations},
                      {"seconds", m.seconds}});
  for (const EconomyRefusal& r : economy.refusals)  // (what is not a number becomes null)
    stays.push_back({{"change", r.change}, {"error", r.error}, {"reason", r.reason}});
  return {{"scene", economy.scene},
          {"tolerance", economy.tolerance},
          {"accuracy", economy.accuracy},
          {"quantities", economy.quantities},
          {"models", models},
          {"stays", stays}};
}

Result<void> write_all(const Economy& economy, const std::filesystem::path& folder) {
  const auto scene = write_scene(economy.smallest);
  if (!scene) return tl::unexpected(scene.error());
  if (auto done = write_whole(folder / "scene.toml", *scene); !done) return done;
  if (auto done = write_whole(folder / "economy.csv", economy_csv(economy)); !done) return done;
  for (const auto& [name, plot] : economy_plots(economy)) {
    const std::string drawing = svg(plot);
    if (auto done = write_whole(folder / (name + ".svg"), drawing); !done) return done;
    if (auto done = write_png(drawing, folder / (name + ".png")); !done) return done;
  }
  return write_whole(folder / "economy.html", economy_page(economy));
}

void print(const Economy& economy) {
  fmt::print("  {:40} {:>10} {:>11} {:>6} {:>10} {:>11}\n", "", "error", "coordinates", "bodies", "ms",
             "evaluations");
  for (const EconomyModel& m : economy.models)
    fmt::print("  {:40} {:10.2g} {:11} {:6} {:10.3g} {:11}\n",
               m.change.empty() ? "the whole model" : m.change + " locked", m.error, m.coordinates, m.bodies,
               1e3 * m.seconds, m.evaluations);
  for (const EconomyRefusal& r : economy.refusals)
    fmt::print("  stays: {:33} {}\n", r.change,
               std::isnan(r.error) ? r.reason : fmt::format("{:10.2g}", r.error));
  fmt::print("{}\n", in_words(economy));
}

Result<nlohmann::json> work(const Options& o, const Command& command) {
  const std::filesystem::path folder = o.folder;
  if (auto fine = check_folder_writable(folder); !fine) return tl::unexpected(fine.error());
  auto model = read_model(o.scene, o.model);
  if (!model) return tl::unexpected(model.error());
  if (!command.json) fmt::print("{}", not_modelled_text(model->not_modelled));
  model->scene.simulation.end_time = o.end.value_or(model->scene.simulation.end_time);
  ProgressBar bar(command.json);
  bar.begin("economy");
  const auto economy = scene_economy(model->scene, o.settings,
                                     [&](const std::string&, double fraction) { bar.update(fraction); });
  if (!economy) return tl::unexpected(economy.error());
  bar.end(fmt::format("{} models", economy->models.size()));
  if (auto done = write_all(*economy, folder); !done) return tl::unexpected(done.error());
  if (!command.json) {
    print(*economy);
    fmt::print("{}: the smallest model; beside it a page, SVG, PNG and CSV\n",
               (folder / "scene.toml").string());
  }
  return json_of(*economy);
}

}  // namespace

void add_economy(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand(
      "economy", "Find the smallest model of a scene whose motion stays within a tolerance");
  auto o = std::make_shared<Options>();
  verb->add_option("scene", o->scene, "The scene: TOML, MJCF or URDF")->required();
  add_model_options(*verb, o->model);
  verb->add_option("-o,--output", o->folder, "Folder for the scene, page, drawings and table")
      ->capture_default_str();
  verb->add_option("--quantity", o->settings.quantities,
                   "What is to stay within the tolerance: centre, solid:NAME, solid:NAME:x,y,z, turn:NAME, "
                   "coordinate:NAME; several may follow; all solids' gravity centres, where not given");
  verb->add_option("--tolerance", o->settings.tolerance,
                   "Largest error, of lengths over the scene's, of angles in rad")
      ->check(number_within(1e-9, 1.))
      ->capture_default_str();
  verb->add_option("--end", o->end, "End time, s")->check(positive_number());
  verb->add_option("--outputs", o->settings.outputs, "Times at which motions are compared")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  verb->add_option("--repeats", o->settings.repeats, "Runs that a time is the median of")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
