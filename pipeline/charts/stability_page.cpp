#include "pipeline/charts/stability_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "pipeline/charts/chart_page.hpp"

namespace borelli {
namespace {

// a factor of a million, as a natural logarithm
constexpr double much_growth = 13.8;

std::string setting_words(const StabilityMap& map, std::size_t method, double setting) {
  return method_is_adaptive(map.methods[method]) ? fmt::format("tolerance {:.4g}", setting)
                                                 : fmt::format("step {:.4g} s", setting);
}

std::string tip(const StabilityMap& map, const StabilityCell& cell) {
  const Tried& t = cell.tried;
  std::string out = fmt::format("{}\n{}: {}", map.sweep.names[cell.column],
                                setting_words(map, cell.method, cell.setting), name_of(t.outcome));
  if (t.steps > 0)
    out += fmt::format("\n{} steps to {:.4g} s, {} evaluations", t.steps, t.end, t.evaluations);
  if (std::isfinite(t.energy)) out += fmt::format("\nenergy error {:.2g} of the energy turnover", t.energy);
  if (std::isfinite(t.constraint)) out += fmt::format("\nconstraint error {:.2g}", t.constraint);
  return t.reason.empty() ? out : out + "\n" + t.reason;
}

/// Unit of a number in the scene's file, by the last key of its path; empty: none, or ambiguous.
std::string_view unit_of(std::string_view path) {
  std::string_view key = path.substr(path.rfind('.') == path.npos ? 0 : path.rfind('.') + 1);
  key = key.substr(0, key.find('['));
  constexpr std::pair<std::string_view, std::string_view> units[] = {{"mass", "kg"},
                                                                     {"density", "kg/m³"},
                                                                     {"gravity", "m/s²"},
                                                                     {"step", "s"},
                                                                     {"end_time", "s"},
                                                                     {"radius", "m"},
                                                                     {"length", "m"},
                                                                     {"size", "m"},
                                                                     {"rest_length", "m"},
                                                                     {"rest_speed", "m/s"},
                                                                     {"baumgarte_alpha", "1/s"},
                                                                     {"baumgarte_beta", "1/s"},
                                                                     {"output_interval", "s"},
                                                                     {"value_deg", "degrees"}};
  const auto found =
      std::find_if(std::begin(units), std::end(units), [&](const auto& u) { return u.first == key; });
  return found == std::end(units) ? "" : found->second;
}

std::string column_label(const Sweep& sweep) {
  if (sweep.parameter.empty()) return "scene";
  const std::string_view unit = unit_of(sweep.parameter);
  return fmt::format("{} ({})", sweep.parameter, unit.empty() ? "as in the scene's file, SI" : unit);
}

Axis column_axis(const StabilityMap& map) {
  const std::vector<double> bounds = tile_bounds(map.sweep.values);
  return {.label = column_label(map.sweep),
          .logarithmic = map.sweep.values.logarithmic,
          .low = bounds.front(),
          .high = bounds.back(),
          .whole_numbers = map.sweep.parameter.empty()};
}

}  // namespace

std::string own_growth_words(const StabilityMap& map) {
  double most = 0;
  std::size_t column = 0, count = 0;
  for (std::size_t i = 0; i < map.own_growth.size(); ++i) {
    if (map.own_growth[i] < much_growth) continue;
    ++count;
    if (map.own_growth[i] > most) most = map.own_growth[column = i];
  }
  if (count == 0) return "";
  return fmt::format(
      "Small deviations from the start grow by themselves, {}by e^{:.3g} in the scene's time{}: such growth "
      "may belong to the motion, not to the method.",
      map.sweep.names.size() > 1 ? fmt::format("with {} ", map.sweep.names[column]) : "", most,
      count > 1 ? fmt::format(", and with {} other values", count - 1) : "");
}

namespace {

std::vector<std::string> notes_of(const StabilityMap& map) {
  std::vector<std::string> notes;
  if (map.sweep.parameter.empty() && map.sweep.names.size() > 1) {
    std::string names = "Scenes: ";
    for (std::size_t i = 0; i < map.sweep.names.size(); ++i)
      names += fmt::format("{}{} {}", i > 0 ? ", " : "", i + 1, map.sweep.names[i]);
    notes.push_back(names + ".");
  }
  notes.push_back(
      fmt::format("Runs last to the scene's end, or for {} steps if those take less time. Runs that need "
                  "more than {} steps stop there and are unfinished.",
                  map.lengths.least, map.lengths.most));
  if (const std::string growing = own_growth_words(map); !growing.empty()) notes.push_back(growing);
  if (std::any_of(map.limits.begin(), map.limits.end(), [](const auto& limit) { return limit.over > 0; }))
    notes.push_back("Empty dots: limits found in the first part of the scene's time only.");
  return notes;
}

/// A curve of one number of a method's limits.
template <class Number>
Curve line_of(const StabilityMap& map, std::size_t method, const std::string& name, Number&& number) {
  Curve curve{.name = name, .marks = true};
  for (const StabilityLimit& limit : map.limits) {
    if (limit.method != method) continue;
    curve.x.push_back(map.sweep.values.values[limit.column]);
    const double value = number(limit);
    curve.y.push_back(value > 0 && std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN());
    const bool of_a_part = value == limit.stable && limit.over > 0;
    curve.hollow.push_back(of_a_part);
    curve.tips.push_back(fmt::format("{}\n{}: {}{}", map.sweep.names[limit.column], name,
                                     setting_words(map, method, value),
                                     of_a_part ? fmt::format(", in the first {:.3g} s", limit.over) : ""));
  }
  return curve;
}

bool has_points(const Curve& curve) {
  return std::any_of(curve.y.begin(), curve.y.end(), [](double y) { return std::isfinite(y); });
}

Plot map_of(const StabilityMap& map, std::size_t method) {
  const Ladder& ladder = map.ladder_of(method);
  const bool adaptive = method_is_adaptive(map.methods[method]);
  const std::vector<double> x = tile_bounds(map.sweep.values), y = tile_bounds(ladder);
  Plot plot;
  plot.title = fmt::format("{}: {}", map.sweep.scene, map.methods[method]);
  plot.x = column_axis(map);
  plot.y = {.label = adaptive ? "tolerance" : "step (s)",
            .logarithmic = ladder.logarithmic,
            .low = y.front(),
            .high = y.back()};
  plot.kinds = outcome_names();
  plot.notes = notes_of(map);
  std::size_t row = 0;
  for (const StabilityCell& cell : map.cells) {
    if (cell.method != method) continue;
    const std::size_t i = row++ % ladder.values.size();
    plot.tiles.push_back({x[cell.column], x[cell.column + 1], y[i], y[i + 1], std::size_t(cell.tried.outcome),
                          tip(map, cell)});
  }
  plot.curves = {line_of(map, method, "limit of stability", [](const auto& l) { return l.stable; }),
                 line_of(map, method, "trusted up to", [](const auto& l) { return l.trusted; }),
                 line_of(map, method, "linear limit at the start",
                         [](const auto& l) { return l.linear.value_or(NAN); })};
  // theory is a line and may lie beyond the tried settings; the runs are points on their own line
  if (map.sweep.scenes.size() > 1) plot.curves[2].marks = false;
  for (Curve& curve : plot.curves)
    for (double& value : curve.y)
      if (!(value >= y.front() && value <= y.back())) value = std::numeric_limits<double>::quiet_NaN();
  std::erase_if(plot.curves, [](const Curve& curve) { return !has_points(curve); });
  return plot;
}

/// For a single column, where limits would be one dot per method: the outcome of every method at every
/// setting.
Plot methods_plot(const StabilityMap& map, bool adaptive) {
  const Ladder& ladder = adaptive ? map.tolerances : map.steps;
  const std::vector<double> y = tile_bounds(ladder);
  Plot plot{.title = map.sweep.scene + ": outcome of each method's runs",
            .x = {.label = "method", .whole_numbers = true},
            .y = {.label = adaptive ? "tolerance" : "step (s)",
                  .logarithmic = ladder.logarithmic,
                  .low = y.front(),
                  .high = y.back()},
            .curves = {},
            .kinds = outcome_names()};
  std::vector<std::size_t> methods;
  std::string names;
  for (std::size_t m = 0; m < map.methods.size(); ++m) {
    if (method_is_adaptive(map.methods[m]) != adaptive) continue;
    methods.push_back(m);
    plot.x.ticks.push_back(double(methods.size()));
    names += fmt::format("{}{} {}", names.empty() ? "" : ", ", methods.size(), map.methods[m]);
  }
  plot.x.low = 0.5, plot.x.high = double(methods.size()) + 0.5;
  for (std::size_t n = 0; n < methods.size(); ++n) {
    std::size_t i = 0;
    for (const StabilityCell& cell : map.cells) {
      if (cell.method != methods[n]) continue;
      plot.tiles.push_back({double(n) + 0.5, double(n) + 1.5, y[i], y[i + 1], std::size_t(cell.tried.outcome),
                            map.methods[methods[n]] + "\n" + tip(map, cell)});
      ++i;
    }
  }
  plot.notes = notes_of(map);
  plot.notes.insert(plot.notes.begin(), "Methods: " + names + ".");
  return plot;
}

Plot limits_plot(const StabilityMap& map, bool adaptive) {
  Plot plot;
  plot.title = fmt::format("{}: limits of stability", map.sweep.scene);
  plot.x = column_axis(map);
  plot.y = {.label = adaptive ? "largest stable tolerance" : "largest stable step (s)", .logarithmic = true};
  std::string free;
  for (std::size_t m = 0; m < map.methods.size(); ++m) {
    if (method_is_adaptive(map.methods[m]) != adaptive) continue;
    Curve curve = line_of(map, m, map.methods[m], [](const auto& l) { return l.stable; });
    if (has_points(curve))
      plot.curves.push_back(std::move(curve));
    else if (std::all_of(map.limits.begin(), map.limits.end(), [&](const auto& l) {
               return l.method != m || (std::isinf(l.stable) && l.unseen == 0);
             }))
      free += (free.empty() ? "" : ", ") + map.methods[m];
  }
  plot.notes = notes_of(map);
  if (!free.empty()) plot.notes.push_back("Stable at every tried setting: " + free + ".");
  return plot;
}

}  // namespace

std::string limit_words(double limit) {
  return std::isnan(limit) ? "none" : std::isinf(limit) ? "all" : fmt::format("{:.4g}", limit);
}

std::string stable_words(const StabilityMap& map, const StabilityLimit& limit) {
  if (!limit.known) return "not known";
  if (std::isnan(limit.stable))
    return fmt::format("none from {:.3g} on", map.ladder_of(limit.method).values.front());
  if (limit.unseen > 0) return fmt::format("{} above {:.3g}", limit_words(limit.stable), limit.unseen);
  return limit.over > 0 ? fmt::format("{:.4g} in {:.3g} s", limit.stable, limit.over)
                        : limit_words(limit.stable);
}

std::vector<std::pair<std::string, Plot>> stability_plots(const StabilityMap& map) {
  std::vector<std::pair<std::string, Plot>> out;
  for (const bool adaptive : {false, true})
    if (map.sweep.scenes.size() == 1) {
      if (Plot plot = methods_plot(map, adaptive); plot.x.ticks.size() > 1)
        out.emplace_back(adaptive ? "methods_tolerance" : "methods", std::move(plot));
    } else if (Plot plot = limits_plot(map, adaptive); !plot.curves.empty()) {
      out.emplace_back(adaptive ? "limits_tolerance" : "limits", std::move(plot));
    }
  for (std::size_t m = 0; m < map.methods.size(); ++m) out.emplace_back(map.methods[m], map_of(map, m));
  return out;
}

namespace {

std::string limits_table(const StabilityMap& map) {
  std::vector<std::vector<std::string>> rows;
  for (const StabilityLimit& limit : map.limits) {
    const auto first = std::find_if(map.cells.begin(), map.cells.end(), [&](const StabilityCell& c) {
      return c.method == limit.method && c.column == limit.column &&
             (is_unstable(c.tried.outcome) || c.tried.outcome == Outcome::refused);
    });
    const std::string column = map.sweep.parameter.empty()
                                   ? map.sweep.names[limit.column]
                                   : fmt::format("{:.4g}", map.sweep.values.values[limit.column]);
    rows.push_back({map.methods[limit.method], html_text(column), stable_words(map, limit),
                    limit.linear ? limit_words(*limit.linear) : "–", limit_words(limit.trusted),
                    first == map.cells.end() ? "–" : name_of(first->tried.outcome),
                    first == map.cells.end() ? "" : html_text(first->tried.reason)});
  }
  return page_table("Steps in s, tolerances of adaptive methods",
                    {{"method"},
                     {html_text(column_label(map.sweep))},
                     {"stable up to", PageColumn::Kind::number},
                     {"linear", PageColumn::Kind::number},
                     {"trusted up to", PageColumn::Kind::number},
                     {"first failure beyond"},
                     {"its reason", PageColumn::Kind::words}},
                    rows);
}

}  // namespace

std::string stability_page(const StabilityMap& map, const std::vector<std::string>& warnings) {
  ChartPage page{.title = map.sweep.scene + ": stability",
                 .heading = map.sweep.scene + ": where methods fail",
                 .warnings = warnings,
                 .sentences = {"Each run's certificate decides its outcome; a limit is the largest step "
                               "(tolerance) below which no run of the method grows, drifts or stops."}};
  PageButtons which{"map", "Map", {}};
  for (auto& [name, plot] : stability_plots(map)) {
    which.values.emplace_back(name, name == "limits_tolerance"    ? "limits (tolerance)"
                                    : name == "methods"           ? "all methods"
                                    : name == "methods_tolerance" ? "all methods (tolerance)"
                                                                  : name);
    page.plots.push_back({{{"map", name}}, std::move(plot)});
  }
  page.buttons = {which};
  page.body =
      "<section><h2>Limits</h2>\n" + limits_table(map) +
      "<p>all: stable at every tried setting; none "
      "from x on: stable at no tried setting, of which x is the smallest; above x: runs with x and less were "
      "stopped before the scene's end and were sound until then; in 0.5 s: stable in the scene's first 0.5 "
      "s, because runs below the limit were stopped there; not known: these runs stop before any instability "
      "shows (--most-steps lets them continue). Linear: limit from the linear theory of small deviations "
      "from the start. Point at a tile to read its failure; stability.csv lists every run.</p></section>\n";
  return chart_page(page);
}

std::string stability_csv(const StabilityMap& map) {
  std::string out = "parameter,method,setting,outcome,end_s,steps,evaluations,energy,constraint,reason\n";
  const auto number = [](double x) { return std::isfinite(x) ? fmt::format("{:.17g}", x) : std::string(); };
  for (const StabilityCell& cell : map.cells)
    out += fmt::format("{:.17g},{},{:.17g},{},{:.17g},{},{},{},{},{}\n", map.sweep.values.values[cell.column],
                       map.methods[cell.method], cell.setting, name_of(cell.tried.outcome), cell.tried.end,
                       cell.tried.steps, cell.tried.evaluations, number(cell.tried.energy),
                       number(cell.tried.constraint), csv_text(cell.tried.reason));
  return out;
}

std::string stability_limits_csv(const StabilityMap& map) {
  std::string out = "parameter,name,method,stable,linear,trusted,known,over_s,unseen\n";
  const auto number = [](double x) {
    return std::isfinite(x) ? fmt::format("{:.17g}", x) : std::isinf(x) ? std::string("inf") : std::string();
  };
  for (const StabilityLimit& limit : map.limits)
    out += fmt::format("{:.17g},{},{},{},{},{},{},{},{}\n", map.sweep.values.values[limit.column],
                       csv_text(map.sweep.names[limit.column]), map.methods[limit.method],
                       number(limit.stable), limit.linear ? number(*limit.linear) : "", number(limit.trusted),
                       limit.known ? "yes" : "no", limit.over > 0 ? number(limit.over) : "",
                       limit.unseen > 0 ? number(limit.unseen) : "");
  return out;
}

std::vector<std::pair<std::string, std::string>> failing_scenes(const StabilityMap& map,
                                                                const StabilitySettings& settings) {
  std::vector<std::pair<std::string, std::string>> out;
  for (std::size_t m = 0; m < map.methods.size(); ++m)
    for (int o = 0; o < int(outcome_names().size()); ++o) {
      const StabilityCell* nearest = nullptr;
      for (const StabilityCell& cell : map.cells)
        if (cell.method == m && cell.tried.outcome == Outcome(o) && is_unstable(Outcome(o)) &&
            (!nearest || cell.setting < nearest->setting))
          nearest = &cell;
      if (!nearest) continue;
      Scene scene = *map.sweep.scenes[nearest->column];
      SimulationSettings& how = scene.simulation;
      how.method = map.methods[m];
      how.equations = settings.equations;
      how.constraints = settings.constraints.value_or(how.constraints);
      (method_is_adaptive(how.method) ? how.tolerance : how.step) = nearest->setting;
      const auto text = write_scene(scene);
      if (!text) continue;  // a scene from a file can always be written
      std::string outcome = name_of(Outcome(o));
      const std::string first = fmt::format("# fails: {} at {:.17g} by {}: {}\n", how.method,
                                            nearest->setting, outcome, nearest->tried.reason);
      std::replace(outcome.begin(), outcome.end(), ' ', '_');
      out.emplace_back(fmt::format("{}_{}.toml", how.method, outcome), first + *text);
    }
  return out;
}

}  // namespace borelli
