// borelli economy SCENE_OR_VOLUME -o DIR: the smallest model of a scene whose motion stays within a
// tolerance, or the coarsest voxels and grid of a scan whose table stays within it.
#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/charts/economy_page.hpp"
#include "pipeline/charts/picture.hpp"
#include "pipeline/charts/volume_economy.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "pipeline/verbs/volume_info.hpp"

namespace borelli {
namespace {

struct EconomyOptions {
  std::string input, folder = "economy", model_tolerance, table_tolerance, quantity;
  ModelOptions model;
  std::optional<double> end;
  EconomySettings settings;
  bool of_scene = false;  ///< an option was given that does not apply to volumes
};

/// All files written for an input.
std::vector<std::string> files_of(const std::string& input) {
  const bool volume = may_be_volume(input);
  std::vector<std::string> out = plot_files(volume ? volume_economy_plot_names() : economy_plot_names());
  out.insert(out.end(), {"economy.csv", "economy.html"});
  if (!volume) out.emplace_back("scene.toml");
  return out;
}

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
  for (const EconomyRefusal& r : economy.refusals)  // NaN becomes null
    stays.push_back({{"change", r.change}, {"error", r.error}, {"reason", r.reason}});
  return {{"scene", economy.scene},
          {"tolerance", economy.tolerance},
          {"accuracy", economy.accuracy},
          {"quantities", economy.quantities},
          {"instants", economy.instants},
          {"search",
           {{"runs", economy.runs}, {"evaluations", economy.evaluations}, {"seconds", economy.seconds}}},
          {"models", models},
          {"stays", stays}};
}

Result<void> write_all(const Economy& economy, const std::filesystem::path& folder,
                       const std::vector<std::string>& warnings) {
  const auto scene = write_scene(economy.smallest);
  if (!scene) return tl::unexpected(scene.error());
  if (auto done = write_whole(folder / "scene.toml", *scene); !done) return done;
  if (auto done = write_whole(folder / "economy.csv", economy_csv(economy)); !done) return done;
  if (auto done = write_plots(economy_plots(economy), folder); !done) return done;
  return write_whole(folder / "economy.html", economy_page(economy, warnings));
}

void print(const Economy& economy) {
  fmt::print("  {:40} {:>10} {:>11} {:>6} {:>10} {:>11}\n", "", "error", "coordinates", "bodies", "ms",
             "evaluations");
  for (const EconomyModel& m : economy.models)
    fmt::print("  {:40} {:10.2g} {:11} {:6} {:10.3g} {:11}\n",
               m.change.empty() ? "the whole model" : m.change + " locked", m.error, m.coordinates, m.bodies,
               1e3 * m.seconds, m.evaluations);
  for (const EconomyRefusal& r : economy.refusals)
    fmt::print("  kept free: {:33} {}\n", r.change,
               std::isnan(r.error) ? r.reason : fmt::format("{:10.2g}", r.error));
  fmt::print("{}\n", in_words(economy));
}

Result<nlohmann::json> work_on_volume(const EconomyOptions& o, const Command& command) {
  const std::filesystem::path folder = o.folder;
  if (o.of_scene || o.model.floating)
    return bad_use(
        o.input,
        "is a volume: only --table-tolerance and --quantity apply; leave out the options for scenes");
  const auto scanned = read_volume(command, o.input, o.quantity);
  if (!scanned) return tl::unexpected(scanned.error());
  if (scanned->volume.quantity == Quantity::mr)
    return bad_use(o.input, "is an MR volume, which gives no densities; give a CT or density volume");
  ProgressBar bar(command.json);
  bar.begin("economy");
  const auto economy = volume_economy(scanned->volume, o.settings.tolerance, command.threads,
                                      [&](double fraction) { bar.update(fraction); });
  if (!economy) return tl::unexpected(economy.error());
  bar.end(fmt::format("{} tables", economy->trials.size()));
  command.warn(economy->warnings);
  if (auto done = write_plots(volume_economy_plots(*economy), folder); !done)
    return tl::unexpected(done.error());
  const std::string title = command.names().name_of(o.input);
  for (const auto& [name, text] :
       {std::pair("economy.csv", volume_economy_csv(*economy)),
        std::pair("economy.html", volume_economy_page(*economy, title, command.warnings_in_files()))})
    if (auto done = write_whole(folder / name, text); !done) return tl::unexpected(done.error());
  nlohmann::json trials = nlohmann::json::array();
  for (const VolumeTrial& t : economy->trials)
    for (std::size_t c = 0; c < std::size(parts_choices); ++c)  // non-finite numbers become null
      trials.push_back({{"of", t.of == VolumeTrial::Of::work_grid ? "work grid"
                               : t.of == VolumeTrial::Of::voxels  ? "voxels"
                                                                  : "density curve"},
                        {"name", t.name},
                        {"parts", parts_choices[c].count},
                        {"error", t.worst(c)},
                        {"seconds", t.seconds}});
  if (!command.json) {
    for (const std::string& sentence : in_words(*economy)) fmt::print("{}\n", sentence);
    fmt::print("{}: page with the drawings; SVG, PNG and CSV files are beside it\n",
               (folder / "economy.html").string());
  }
  nlohmann::json doubt = nlohmann::json::array();
  for (std::size_t c = 0; c < std::size(parts_choices); ++c)
    doubt.push_back({{"parts", parts_choices[c].count}, {"differs_by", economy->doubt(c)}});
  const VolumeTrial* next = economy->next_to_reference();
  return nlohmann::json{{"volume", o.input},
                        {"tolerance", economy->tolerance},
                        {"reference",
                         {{"work_grid_mm", economy->trials.front().size},
                          {"next_mm", next ? nlohmann::json(next->size) : nlohmann::json()},
                          {"doubt", doubt}}},
                        {"trials", trials}};
}

Result<nlohmann::json> work_on_scene(const EconomyOptions& o, const Command& command) {
  const std::filesystem::path folder = o.folder;
  for (const auto& [option, given] :
       {std::pair("--quantity", &o.quantity), {"--table-tolerance", &o.table_tolerance}})
    if (!given->empty())
      return bad_use(option, "applies only to volumes, and " + o.input +
                                 " is a scene; use --keep and --model-tolerance");
  auto model = read_model_for_pages(command, o.input, o.model);
  if (!model) return tl::unexpected(model.error());
  model->scene.simulation.end_time = o.end.value_or(model->scene.simulation.end_time);
  ProgressBar bar(command.json);
  bar.begin("economy");
  const auto economy = scene_economy(model->scene, o.settings,
                                     [&](const std::string&, double fraction) { bar.update(fraction); });
  if (!economy) return tl::unexpected(economy.error());
  bar.end(fmt::format("{} models", economy->models.size()));
  if (auto done = write_all(*economy, folder, command.warnings_in_files()); !done)
    return tl::unexpected(done.error());
  if (!command.json) {
    print(*economy);
    fmt::print("{}: the smallest model; a page, SVG, PNG and CSV files are beside it\n",
               (folder / "scene.toml").string());
  }
  return json_of(*economy);
}

}  // namespace

void add_economy(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("economy",
                                      "Find the smallest model of a scene, or the coarsest voxels and work "
                                      "grid of a scan, whose result stays within a tolerance");
  auto o = std::make_shared<EconomyOptions>();
  verb->add_option("input", o->input, "Scene (TOML, MJCF, URDF or OpenSim), or CT or density volume")
      ->required();
  add_output(*verb, o->folder, "FOLDER", "Folder for the scene, the page, the drawings and the table")
      ->capture_default_str();
  add_shared(*verb, flags::model_tolerance, o->model_tolerance, " (default: 1%)");
  add_shared(*verb, flags::keep, o->settings.quantities);
  add_shared(*verb, flags::end, o->end);
  add_shared(*verb, flags::samples, o->settings.outputs)->capture_default_str();
  add_shared(*verb, flags::table_tolerance, o->table_tolerance, " (default: 1%)");
  add_shared(*verb, flags::quantity, o->quantity, flags::quantity_default);
  group_options(*verb, "Scene", {"--model-tolerance", "--keep", "--end", "--samples"});
  group_options(*verb, "Volume", {"--table-tolerance", "--quantity"});
  add_model_options(*verb, o->model);
  verb->callback([&command, o, verb] {
    for (const char* option : {"--model-tolerance", "--keep", "--end", "--samples"})
      o->of_scene = o->of_scene || verb->count(option) > 0;
    command.work = [o](const Command& c) -> Result<nlohmann::json> {
      const std::string& given = o->model_tolerance.empty() ? o->table_tolerance : o->model_tolerance;
      if (!given.empty()) {
        const auto tolerance = parse_tolerance(given, 1e-9, 1);
        if (!tolerance) return tl::unexpected(tolerance.error());
        o->settings.tolerance = *tolerance;
      }
      if (auto fine = check_folder_writable(o->folder, files_of(o->input)); !fine)
        return tl::unexpected(fine.error());
      if (std::error_code problem; !std::filesystem::exists(o->input, problem))
        return bad_use(o->input, "no such file or folder");
      return may_be_volume(o->input) ? work_on_volume(*o, c) : work_on_scene(*o, c);
    };
  });
}

}  // namespace borelli
