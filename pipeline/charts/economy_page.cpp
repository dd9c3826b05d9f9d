#include "pipeline/charts/economy_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "error/plain_cell.hpp"
#include "pipeline/charts/chart_page.hpp"

namespace borelli {
namespace {

std::string change_words(const EconomyModel& model) {
  return model.change.empty() ? "the whole model" : model.change + " locked";
}

std::string tip(const EconomyModel& model) {
  std::string out =
      fmt::format("{}\n{} coordinates, {} bodies\n{:.3g} ms, {} evaluations", change_words(model),
                  model.coordinates, model.bodies, 1e3 * model.seconds, model.evaluations);
  if (!model.change.empty()) out += fmt::format("\nerror {:.2g}: {}", model.error, model.worst);
  return out;
}

}  // namespace

std::vector<std::pair<std::string, Plot>> economy_plots(const Economy& economy) {
  Plot error, time;
  error.title = economy.scene + ": error of smaller models";
  time.title = economy.scene + ": time of smaller models";
  error.x = time.x = {.label = "coordinates kept", .whole_numbers = true};
  error.y = {.label = "largest error (of the length, or rad)", .logarithmic = true};
  time.y = {.label = "processor time of a run (ms)", .low = 0};
  Curve errors{.name = "model", .marks = true}, times = errors, bound{.name = "tolerance"};
  for (const EconomyModel& model : economy.models) {
    const double count = model.coordinates;
    errors.x.push_back(count);
    // errors below the accuracy cannot be resolved
    errors.y.push_back(std::max(model.error, economy.accuracy));
    bound.x.push_back(count);
    bound.y.push_back(economy.tolerance);
    times.x.push_back(count);
    times.y.push_back(1e3 * model.seconds);
    errors.tips.push_back(tip(model));
    times.tips.push_back(tip(model));
  }
  if (bound.x.size() == 1) {  // a single point makes no line
    bound.x = {bound.x[0] - 0.5, bound.x[0] + 0.5};
    bound.y.push_back(economy.tolerance);
  }
  error.curves = {errors, bound};
  time.curves = {times};
  error.notes = {fmt::format(
      "Errors below {:.2g} are not resolved. Compared with the whole model, for {}, at {} times{}.",
      economy.accuracy, fmt::join(economy.quantities, ", "), economy.instants,
      economy.sparse ? ", which are too few for its shortest steps, so quick motion may be missed" : "")};
  return {{"error", error}, {"time", time}};
}

std::string economy_csv(const Economy& economy) {
  std::string out = "change,error,worst,coordinates,bodies,rows,evaluations,seconds\n";
  for (const EconomyModel& m : economy.models)
    out += fmt::format("{},{:.17g},{},{},{},{},{},{:.6g}\n", csv_text(m.change), m.error, csv_text(m.worst),
                       m.coordinates, m.bodies, m.rows, m.evaluations, m.seconds);
  out += fmt::format("# the search: {} runs, {} evaluations\n", economy.runs, economy.evaluations);
  for (const EconomyRefusal& r : economy.refusals)
    out += plain_comment(fmt::format("# kept free: {}: {}\n", r.change,
                                     std::isnan(r.error) ? r.reason : fmt::format("error {:.6g}", r.error)));
  return out;
}

std::string in_words(const Economy& economy) {
  const EconomyModel &whole = economy.models.front(), &least = economy.models.back();
  std::string cost =
      fmt::format("; the search took {} runs, and as many evaluations as {:.3g} runs of the whole model",
                  economy.runs, double(economy.evaluations) / double(std::max(whole.evaluations, 1L)));
  if (economy.sparse)
    cost +=
        fmt::format("; {} output times are too few for the motion's shortest steps; give more with --samples",
                    economy.instants);
  if (economy.models.size() == 1)
    return fmt::format("none of the scene's {} coordinates can be locked within {:g}", whole.coordinates,
                       economy.tolerance) +
           cost;
  return fmt::format(
             "{} of {} coordinates and {} of {} moving bodies suffice within {:g}: error {:.2g}, in {:.2g} "
             "of the time ({:.2g} per evaluation)",
             least.coordinates, whole.coordinates, least.bodies, whole.bodies, economy.tolerance, least.error,
             least.seconds / whole.seconds,
             least.seconds / double(least.evaluations) / (whole.seconds / double(whole.evaluations))) +
         cost;
}

std::string economy_page(const Economy& economy, const std::vector<std::string>& warnings) {
  ChartPage page{.title = economy.scene + ": economy",
                 .heading = economy.scene + ": the smallest sufficient model",
                 .warnings = warnings,
                 .sentences = {"Result: " + in_words(economy) + "."}};
  PageButtons which{"of", "Chart", {}};
  for (auto& [name, plot] : economy_plots(economy)) {
    which.values.emplace_back(name, name == "error" ? "error" : "processor time");
    page.plots.push_back({{{"of", name}}, std::move(plot)});
  }
  page.buttons = {which};
  std::vector<std::vector<std::string>> models, kept;
  for (const EconomyModel& m : economy.models)
    models.push_back({html_text(change_words(m)), fmt::format("{:.2g}", m.error), html_text(m.worst),
                      fmt::format("{}", m.coordinates), fmt::format("{}", m.bodies),
                      fmt::format("{:.3g}", 1e3 * m.seconds), fmt::format("{}", m.evaluations),
                      fmt::format("{:.3g}", 1e6 * m.seconds / double(std::max(m.evaluations, 1L)))});
  for (const EconomyRefusal& r : economy.refusals)
    kept.push_back(
        {html_text(r.change), std::isnan(r.error) ? html_text(r.reason) : fmt::format("{:.2g}", r.error)});
  page.body = "<section><h2>Models</h2>\n" +
              page_table("",
                         {{"change"},
                          {"error", PageColumn::Kind::number},
                          {"worst in", PageColumn::Kind::words},
                          {"coordinates", PageColumn::Kind::number},
                          {"bodies", PageColumn::Kind::number},
                          {"time (ms)", PageColumn::Kind::number},
                          {"evaluations", PageColumn::Kind::number},
                          {"each (µs)", PageColumn::Kind::number}},
                         models) +
              "</section>\n";
  if (!kept.empty())
    page.body += "<section><h2>What stays free</h2>\n" +
                 page_table("", {{"locking"}, {"error", PageColumn::Kind::words}}, kept) + "</section>\n";
  return chart_page(page);
}

}  // namespace borelli
