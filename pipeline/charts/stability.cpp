#include "pipeline/charts/stability.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "pipeline/charts/linear_limit.hpp"
#include "pipeline/charts/scene_number.hpp"

namespace borelli {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double all = std::numeric_limits<double>::infinity();

class Mapping {
 public:
  Mapping(StabilityMap& map, const StabilitySettings& settings, const StabilityObserver& observer)
      : map_(map), settings_(settings), observer_(observer) {}

  Result<void> run() {
    const std::size_t columns = map_.sweep.scenes.size(), methods = map_.methods.size();
    std::vector<Result<System>> systems;
    std::vector<std::optional<SmallDeviations>> deviations;
    for (const Result<Scene>& scene : map_.sweep.scenes) {
      systems.push_back(scene ? compile(*scene) : tl::unexpected(scene.error()));
      deviations.push_back(systems.back() ? deviations_from_start(*systems.back()) : std::nullopt);
      map_.own_growth.push_back(deviations.back()
                                    ? growth_rate(*deviations.back()) *
                                          (systems.back()->settings.end_time - systems.back()->initial.t)
                                    : 0);
    }
    for (std::size_t m = 0; m < methods; ++m)
      for (std::size_t c = 0; c < columns; ++c) {
        if (take_known(m, c)) continue;
        climb(m, c, systems[c]);
        if (deviations[c] && settings_constraints(systems[c]) == ConstraintTreatment::projection)
          map_.limits.back().linear = linear_limit(map_.methods[m], *deviations[c]);
        observer_.progress(double(m * columns + c + 1) / double(methods * columns));
        if (auto done = observer_.column_ends(map_); !done) return done;
      }
    return {};
  }

 private:
  bool take_known(std::size_t method, std::size_t column) {
    const auto here = [&](const auto& one) { return one.method == method && one.column == column; };
    const auto limit = std::find_if(observer_.known_limits.begin(), observer_.known_limits.end(), here);
    if (limit == observer_.known_limits.end()) return false;
    map_.limits.push_back(*limit);
    std::copy_if(observer_.known_cells.begin(), observer_.known_cells.end(), std::back_inserter(map_.cells),
                 here);
    return true;
  }

  ConstraintTreatment settings_constraints(const Result<System>& system) const {
    return settings_.constraints.value_or(system->settings.constraints);
  }

  Tried tried(std::size_t method, const Result<System>& system, double setting) const {
    if (!system) return {.outcome = Outcome::refused, .reason = system.error().message()};
    return try_run(*system, settings_for(method, *system), setting, map_.lengths);
  }

  SimulationSettings settings_for(std::size_t method, const System& system) const {
    SimulationSettings how = system.settings;
    how.method = map_.methods[method];
    how.equations = settings_.equations;
    how.constraints = settings_.constraints.value_or(how.constraints);
    return how;
  }

  /// Runs with a fixed step up to a time before the scene's end.
  Tried tried_until(double end, std::size_t method, const Result<System>& system, double step) const {
    SimulationSettings how = settings_for(method, *system);
    how.end_time = end;
    return try_run(*system, how, step, {1, map_.lengths.most + 1});
  }

  /// Runs all settings of the ladder, from small to large, and bisects the limits between them.
  void climb(std::size_t method, std::size_t column, const Result<System>& system) {
    StabilityLimit limit{method, column, none, none};
    bool stable = true, trusted = true, refused = false;
    double unstable_from = none, cut = none, cut_end = none;  // `cut`: largest setting of an unfinished run
    for (const double setting : map_.ladder_of(method).values) {
      const Tried now = tried(method, system, setting);
      map_.cells.push_back({method, column, setting, now});
      if (now.outcome == Outcome::unfinished) {
        if (stable) cut = setting, cut_end = now.end;
        continue;
      }
      if (stable && is_unstable(now.outcome)) unstable_from = setting;
      refused = refused || now.outcome == Outcome::refused;
      stable = stable && !is_unstable(now.outcome) && now.outcome != Outcome::refused;
      trusted = trusted && now.outcome == Outcome::stable;
      if (stable) limit.stable = setting, limit.unseen = std::isfinite(cut) ? cut : 0;
      if (trusted) limit.trusted = setting;
    }
    const bool any = std::isfinite(limit.stable), some = std::isfinite(limit.trusted);
    if (stable && any) limit.stable = all;
    if (trusted && some) limit.trusted = all;
    if (any && std::isfinite(unstable_from)) {
      refine(limit, unstable_from, [&](double step) { return tried(method, system, step); });
    } else if (!any && std::isfinite(cut) && !refused) {
      // compare over equal times; an adaptive run ends where its steps are used up
      const auto as_long = [&](double step) { return tried_until(cut_end, method, system, step); };
      limit.known = std::isfinite(unstable_from) && !method_is_adaptive(map_.methods[method]) &&
                    is_unstable(as_long(unstable_from).outcome);
      if (!limit.known) return map_.limits.push_back(limit);
      limit.stable = cut;
      limit.over = cut_end - system->initial.t;
      refine(limit, unstable_from, as_long);
    }
    map_.limits.push_back(limit);
  }

  template <class Run>
  void refine(StabilityLimit& limit, double unstable_from, Run&& run) const {
    while (unstable_from / limit.stable > settings_.refinement) {
      const double middle = std::sqrt(limit.stable * unstable_from);
      (is_unstable(run(middle).outcome) ? unstable_from : limit.stable) = middle;
    }
  }

  StabilityMap& map_;
  const StabilitySettings& settings_;
  const StabilityObserver& observer_;
};

}  // namespace

const Ladder& StabilityMap::ladder_of(std::size_t method) const {
  return method_is_adaptive(methods[method]) ? tolerances : steps;
}

Result<StabilityMap> stability_map(Sweep sweep, const StabilitySettings& settings,
                                   const StabilityObserver& observer) {
  const auto first = std::find_if(sweep.scenes.begin(), sweep.scenes.end(), [](const auto& s) { return s; });
  if (sweep.scenes.empty()) return bad_use("stability", "needs a scene");
  if (first == sweep.scenes.end()) return tl::unexpected(sweep.scenes.front().error());
  const auto system = compile(**first);
  const double span = (*first)->simulation.end_time - (system ? system->initial.t : 0);
  if (!(span > 0))
    return bad_use((*first)->name, "ends at its start, so it has no motion to map; give a later --end");
  StabilityMap map{
      std::move(sweep), settings.methods, settings.steps, settings.tolerances, settings.lengths, {}, {}};
  if (map.methods.empty()) map.methods = integrator_names();
  if (map.steps.values.empty()) {
    map.steps.logarithmic = true;
    for (int i = 0; i < 13; ++i) map.steps.values.push_back(span * std::pow(10, -4 + 0.25 * i));
  }
  if (map.tolerances.values.empty())
    map.tolerances = {{1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2}, true};
  for (const Ladder* ladder : {&map.steps, &map.tolerances})
    if (!(ladder->values.front() > 0))
      return bad_use("stability", fmt::format("a step or tolerance is {:g}; expected positive numbers",
                                              ladder->values.front()));
  if (settings.lengths.least < 8 || settings.lengths.most < settings.lengths.least ||
      !(settings.refinement > 1))
    return bad_use("stability",
                   fmt::format("runs take {} to {} steps; expected a smallest number of at least "
                               "8 and a largest number of at least the smallest",
                               settings.lengths.least, settings.lengths.most));
  if (auto done = Mapping(map, settings, observer).run(); !done) return tl::unexpected(done.error());
  return map;
}

Result<Sweep> sweep_of_number(const std::string& text, const std::string& file,
                              const std::vector<std::string>& paths, const Ladder& values) {
  Sweep sweep{.scene = file, .parameter = fmt::format("{}", fmt::join(paths, ", ")), .values = values};
  for (const double value : values.values) {
    std::string changed = text;
    for (const std::string& path : paths) {
      auto next = with_number(changed, file, path, value);
      if (!next) return tl::unexpected(next.error());
      changed = std::move(*next);
    }
    sweep.scenes.push_back(parse_scene(changed, file));
    if (sweep.scenes.back()) sweep.scene = sweep.scenes.back()->name;
    sweep.names.push_back(fmt::format("{} = {:.6g}", sweep.parameter, value));
  }
  return sweep;
}

Sweep sweep_of_scenes(std::vector<Scene> scenes, const std::vector<std::string>& files) {
  Sweep sweep{.scene = scenes.size() == 1 ? scenes[0].name : fmt::format("{} scenes", scenes.size())};
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    sweep.values.values.push_back(double(i + 1));
    sweep.names.push_back(scenes[i].name);
    sweep.scenes.push_back(std::move(scenes[i]));
  }
  const std::vector<std::string> own = sweep.names;
  const auto last_part = [](const std::string& file) {
    return std::filesystem::path(file).filename().string();
  };
  for (std::size_t i = 0; i < files.size(); ++i) {
    bool same = false, same_file = false;
    for (std::size_t k = 0; k < files.size(); ++k) {
      if (k == i || own[k] != own[i]) continue;
      same = true;
      same_file = same_file || last_part(files[k]) == last_part(files[i]);
    }
    if (same)
      sweep.names[i] +=
          fmt::format(" ({}{})", last_part(files[i]), same_file ? fmt::format(", {}", i + 1) : "");
  }
  return sweep;
}

}  // namespace borelli
