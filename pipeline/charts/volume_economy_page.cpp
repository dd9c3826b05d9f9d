#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/charts/chart_page.hpp"
#include "pipeline/charts/volume_economy.hpp"

namespace borelli {
namespace {

// `share`: of the run time with the whole scan
std::string run_time_in_words(double share) {
  constexpr double alike = 0.1;
  return std::abs(share - 1) < alike ? "run time unchanged" : fmt::format("{:.2g} times the run time", share);
}

using Of = VolumeTrial::Of;

const char* word_for(Of of) {
  return of == Of::work_grid ? "work grid" : of == Of::voxels ? "voxels" : "density curve";
}

std::string percent_or_none(double share) {
  if (!std::isfinite(share)) return "none";
  return share < 0.995 ? fmt::format("{:.2g} %", 100 * share) : fmt::format("{:.0f} %", 100 * share);
}

/// Which table the errors refer to, and how far it can be trusted.
std::string reference_words(const VolumeEconomy& economy) {
  std::string out = fmt::format(
      "errors are relative to the original scan with parts found on a grid of {}, the finest that was tried, "
      "whose own error is unknown",
      economy.trials.front().name);
  const VolumeTrial* next = economy.next_to_reference();
  if (!next) return out + ", because no other grid was tried";
  if (!next->reason.empty()) return out + fmt::format("; the grid of {} gives no table", next->name);
  out += fmt::format("; it and the grid of {} differ by", next->name);
  for (std::size_t c = 0; c < std::size(parts_choices); ++c)
    out += fmt::format("{} {} ({} parts)", c > 0 ? "," : "", percent_or_none(economy.doubt(c)),
                       parts_choices[c].count);
  return out + ", so smaller errors are not significant";
}

/// The entry with the largest error.
std::string worst_words(const VolumeTrial& trial, std::size_t choice) {
  if (!trial.reason.empty()) return trial.reason;
  const EntryErrors* worst = nullptr;
  for (const EntryErrors& e : trial.errors.at(choice))
    if (!worst || e.largest() > worst->largest()) worst = &e;
  if (!worst || worst->largest() == 0) return "no difference";
  const char* entry = worst->largest() == worst->mass     ? "mass"
                      : worst->largest() == worst->centre ? "gravity centre"
                                                          : "principal moments";
  return fmt::format("{}, {}", worst->part, entry);
}

// %: drawn for zero on a logarithmic axis
constexpr double least_drawn = 0.01;

/// `error` gives the text of a trial's error for its tip, or is empty.
Curve curve_of(const VolumeEconomy& economy, Of of, const std::string& name, auto&& value, auto&& error) {
  Curve curve{.name = name, .marks = true};
  std::vector<const VolumeTrial*> trials;
  for (const VolumeTrial& trial : economy.trials)
    if (trial.of == of) trials.push_back(&trial);
  std::sort(trials.begin(), trials.end(), [](const auto* a, const auto* b) { return a->size < b->size; });
  for (const VolumeTrial* trial : trials) {
    curve.x.push_back(trial->size);
    curve.y.push_back(value(*trial));
    curve.tips.push_back(
        fmt::format("{} {}{}\n{:.3g} s", word_for(of), trial->name, error(*trial), trial->seconds));
  }
  return curve;
}

}  // namespace

std::vector<std::pair<std::string, Plot>> volume_economy_plots(const VolumeEconomy& economy) {
  std::vector<std::pair<std::string, Plot>> out;
  for (const Of of : {Of::work_grid, Of::voxels}) {
    const std::string axis = of == Of::voxels ? "longest edge of the voxels (mm)" : "work grid (mm)";
    Plot error{
        .title = fmt::format("Errors of the table with coarser {}", of == Of::voxels ? "voxels" : "grids"),
        .x = {.label = axis},
        .y = {.label = "largest error of an entry (%)", .logarithmic = true},
        .curves = {}};
    for (std::size_t c = 0; c < std::size(parts_choices); ++c) {
      error.curves.push_back(curve_of(
          economy, of, fmt::format("{} parts", parts_choices[c].count),
          [c](const VolumeTrial& t) { return std::max(least_drawn, 100 * t.worst(c)); },
          [c](const VolumeTrial& t) {
            return fmt::format("\n{} parts: error {}", parts_choices[c].count, percent_or_none(t.worst(c)));
          }));
    }
    error.notes = {
        "Relative errors of masses, gravity centres (of the part's length) and principal moments; " +
        reference_words(economy) + ". The axis starts at 0.01 %. 100 %: a part is lost."};
    if (of == Of::voxels)
      error.notes.push_back("Voxels are averaged in whole blocks, so edges double, triple and so on.");
    Plot time{.title = fmt::format("Time saved by coarser {}", of == Of::voxels ? "voxels" : "grids"),
              .x = {.label = axis},
              .y = {.label = "processor time (s)", .low = 0},
              .curves = {curve_of(
                  economy, of, "parts and table", [](const VolumeTrial& t) { return t.seconds; },
                  [](const VolumeTrial&) { return ""; })}};
    out.emplace_back(of == Of::voxels ? "voxels_error" : "grid_error", std::move(error));
    out.emplace_back(of == Of::voxels ? "voxels_time" : "grid_time", std::move(time));
  }
  return out;
}

std::vector<std::string> in_words(const VolumeEconomy& economy) {
  std::vector<std::string> out{reference_words(economy)};
  const VolumeTrial& whole = economy.trials.front();
  for (const Of of : {Of::work_grid, Of::voxels})
    for (std::size_t c = 0; c < std::size(parts_choices); ++c) {
      const VolumeTrial* best = economy.pick(of, c);
      if (best && economy.doubt(c) > economy.tolerance) {
        out.push_back(fmt::format(
            "{} parts within {}: nothing coarser than {} of {} is chosen, and whether it suffices is unknown",
            parts_choices[c].count, percent_or_none(economy.tolerance),
            of == Of::voxels ? "voxels" : "a work grid", best->name));
        continue;
      }
      const auto any = [&](const auto& is_one) {
        return std::any_of(economy.trials.begin(), economy.trials.end(),
                           [&](const VolumeTrial& t) { return t.of == of && is_one(t); });
      };
      if (best && !any([&](const auto& t) { return t.size != best->size; })) {
        out.push_back(fmt::format("{} parts within {}: no {} coarser than {} were tried",
                                  parts_choices[c].count, percent_or_none(economy.tolerance),
                                  of == Of::voxels ? "voxels" : "grids", best->name));
        continue;
      }
      const bool finest = best && !any([&](const auto& t) { return t.size < best->size; });
      if (finest) {
        out.push_back(fmt::format("{} parts within {}: none of the tried {} coarser than {} suffices",
                                  parts_choices[c].count, percent_or_none(economy.tolerance),
                                  of == Of::voxels ? "voxels" : "grids", best->name));
        continue;
      }
      out.push_back(
          best
              ? fmt::format("{} parts within {}: choose {} of {} (error {}, {})", parts_choices[c].count,
                            percent_or_none(economy.tolerance), word_for(of), best->name,
                            percent_or_none(best->worst(c)), run_time_in_words(best->seconds / whole.seconds))
              : fmt::format("{} parts within {}: no tried size of {} suffices", parts_choices[c].count,
                            percent_or_none(economy.tolerance), word_for(of)));
    }
  for (const VolumeTrial& trial : economy.trials)
    if (trial.of == Of::density_curve && trial.name != economy.curve)
      out.push_back(fmt::format("density curve {} differs by up to {} ({})", trial.name,
                                percent_or_none(trial.worst(0)), worst_words(trial, 0)));
  return out;
}

std::string volume_economy_csv(const VolumeEconomy& economy) {
  std::string out = "of,name,size_mm,parts,largest_error,worst,seconds\n";
  for (const VolumeTrial& trial : economy.trials)
    for (std::size_t c = 0; c < std::size(parts_choices); ++c)
      out += fmt::format("{},{},{:.6g},{},{},{},{:.4g}\n", word_for(trial.of), csv_text(trial.name),
                         trial.size, parts_choices[c].count,
                         trial.reason.empty() ? fmt::format("{:.17g}", trial.worst(c)) : "",
                         csv_text(worst_words(trial, c)), trial.seconds);
  return out;
}

std::string volume_economy_page(const VolumeEconomy& economy, const std::string& title,
                                const std::vector<std::string>& warnings) {
  ChartPage page{.title = title + ": economy",
                 .heading = title + ": requirements of the scan",
                 .warnings = warnings,
                 .sentences = in_words(economy)};
  PageButtons which{"of", "Chart", {}};
  for (auto& [name, plot] : volume_economy_plots(economy)) {
    std::string says = name;
    std::replace(says.begin(), says.end(), '_', ' ');
    which.values.emplace_back(name, says);
    page.plots.push_back({{{"of", name}}, std::move(plot)});
  }
  page.buttons = {which};
  std::vector<std::vector<std::string>> rows;
  for (const VolumeTrial& t : economy.trials)
    rows.push_back({word_for(t.of), html_text(t.name), fmt::format("{:.3g}", t.seconds),
                    percent_or_none(t.worst(0)), percent_or_none(t.worst(1)), percent_or_none(t.worst(2)),
                    html_text(worst_words(t, 0))});
  page.body = "<section><h2>Tried</h2>\n" +
              page_table("Largest error of an entry of the table, by its number of parts",
                         {{"what"},
                          {"size"},
                          {"time (s)", PageColumn::Kind::number},
                          {"16 parts", PageColumn::Kind::number},
                          {"14 parts", PageColumn::Kind::number},
                          {"6 parts", PageColumn::Kind::number},
                          {"worst of 16", PageColumn::Kind::words}},
                         rows) +
              "</section>\n";
  return chart_page(page);
}

}  // namespace borelli
