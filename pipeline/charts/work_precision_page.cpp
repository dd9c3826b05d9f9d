#include "pipeline/charts/work_precision_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "error/plain_cell.hpp"
#include "pipeline/charts/chart_page.hpp"
#include "pipeline/charts/picture.hpp"
#include "pipeline/files/whole_file.hpp"

namespace borelli {
namespace {

// least number of named curves in a drawing, if there are so many; the others are grey in the background
constexpr std::size_t most_named = 10, most_named_beside_others = 3;

// largest number of numbered grey curves
constexpr std::size_t most_numbered = 30;

double milliseconds(const WorkPrecisionPoint& p) { return 1e3 * p.seconds; }
double evaluations(const WorkPrecisionPoint& p) { return double(p.evaluations); }

using Ordinate = double (*)(const WorkPrecision&, const WorkPrecisionPoint&);

struct ErrorMeasure {
  const char *file, *title, *axis;
  Ordinate of;
  bool by_reference;  ///< computed by comparison with the reference
};

template <double RunErrors::*error>
double member(const WorkPrecision&, const WorkPrecisionPoint& p) {
  return p.errors.*error;
}

double of_contacts(const WorkPrecision& chart, const WorkPrecisionPoint& p) {
  return chart.has_impacts ? judged_error(chart, p) : std::numeric_limits<double>::quiet_NaN();
}

constexpr ErrorMeasure quantities[] = {
    {"contacts", "contacts", "largest of these errors, each relative to its scale", of_contacts, true},
    {"position", "position", "largest error of position / scene's length", member<&RunErrors::position>,
     true},
    {"orientation", "orientation", "largest error of orientation (rad)", member<&RunErrors::orientation>,
     true},
    {"energy", "energy", "largest drift of energy / energy turnover", member<&RunErrors::energy>, false},
    {"constraint", "constraints", "largest residual of a constraint (m or rad)",
     member<&RunErrors::constraint>, false},
    {"impacts", "times of impacts", "largest error of an impact's time (s)", member<&RunErrors::impacts>,
     true},
    {"momentum", "momentum", "largest error of momentum / largest momentum", member<&RunErrors::momentum>,
     true}};

struct Cost {
  const char *file, *title, *axis;
  double (*of)(const WorkPrecisionPoint&);
};

constexpr Cost costs[] = {{"time", "processor time", "processor time (ms)", milliseconds},
                          {"evaluations", "evaluations", "evaluations of the equations", evaluations}};

std::string setting_words(const WorkPrecision& chart, const WorkPrecisionPoint& p) {
  const std::string_view name = setting_name(chart.variants[p.variant]);
  return fmt::format("{} {:.4g}{}", name, p.setting, name == "step" ? " s" : "");
}

std::string tip(const WorkPrecision& chart, const WorkPrecisionPoint& p) {
  std::string out = fmt::format("{}, {}", name_of(chart.variants[p.variant]), setting_words(chart, p));
  out += fmt::format("\n{:.4g} ms, {} evaluations", milliseconds(p), p.evaluations);
  const auto add = [&](const char* name, double x, const char* unit) {
    if (std::isfinite(x)) out += fmt::format("\n{} {:.2g}{}", name, x, unit);
  };
  add("position", p.errors.position, "");
  add("orientation", p.errors.orientation, " rad");
  add("energy", p.errors.energy, "");
  add("constraints", p.errors.constraint, "");
  add("impacts", p.errors.impacts, " s");
  add("momentum", p.errors.momentum, "");
  if (!p.trusted) out += fmt::format("\nnot trusted: {}", p.reason);
  return out;
}

std::string failed_tip(const WorkPrecision& chart, const WorkPrecisionPoint& p) {
  return fmt::format("{}, {}\ndid not finish: {}", name_of(chart.variants[p.variant]),
                     setting_words(chart, p), p.reason);
}

// Errors above this are completely wrong; their cost means nothing.
constexpr double all_wrong = 0.1;

// Errors above this are drawn at the chart's edge with the failed runs: a diverging run would compress all
// others.
constexpr double beyond = 10;

std::vector<const WorkPrecisionPoint*> front_of(const WorkPrecision& chart, const ErrorMeasure& quantity,
                                                const Cost& cost, Whose whose) {
  return pareto_front(
      chart, cost.of, [&](const auto& p) { return quantity.of(chart, p); },
      quantity.by_reference ? reference_floor(chart) : 0, whose);
}

// Our variants, or the others': first those on their front, then the nearest to it, best first.
std::vector<std::size_t> nearest_to_front(const WorkPrecision& chart, const ErrorMeasure& quantity,
                                          const Cost& cost, Whose whose) {
  const auto front = front_of(chart, quantity, cost, whose);
  std::vector<double> distance(chart.variants.size(), std::numeric_limits<double>::infinity());
  for (const WorkPrecisionPoint& p : chart.points) {
    const double error = quantity.of(chart, p);
    if (!p.finished || !p.trusted || !(error <= all_wrong)) continue;
    double best = std::numeric_limits<double>::infinity();
    for (const WorkPrecisionPoint* f : front)
      if (quantity.of(chart, *f) <= error) best = std::min(best, cost.of(*f));
    if (std::isfinite(best)) distance[p.variant] = std::min(distance[p.variant], cost.of(p) / best);
  }
  for (const WorkPrecisionPoint* f : front) distance[f->variant] = 0;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < chart.variants.size(); ++i)
    if (chart.variants[i].other == (whose == Whose::others)) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return distance[a] < distance[b]; });
  return order;
}

std::string program_of(const Variant& variant) {
  return variant.other ? variant.method.substr(0, variant.method.find(' ')) : "borelli";
}

// Number of those on the front.
std::size_t count_on_front(const WorkPrecision& chart, const ErrorMeasure& quantity, const Cost& cost,
                           Whose whose) {
  std::set<std::size_t> out;
  for (const WorkPrecisionPoint* f : front_of(chart, quantity, cost, whose)) out.insert(f->variant);
  return out.size();
}

// The variants by nearness to their front, split into named and grey ones. Those on a front and the program's
// own choice are always named. Beside other programs, a few of ours are named, and the best of each program.
std::pair<std::vector<std::size_t>, std::vector<std::size_t>> named_and_grey(const WorkPrecision& chart,
                                                                             const ErrorMeasure& quantity,
                                                                             const Cost& cost) {
  const auto others = nearest_to_front(chart, quantity, cost, Whose::others);
  const std::size_t least = std::max(others.empty() ? most_named - 1 : most_named_beside_others,
                                     count_on_front(chart, quantity, cost, Whose::ours));
  std::vector<std::size_t> named, grey;
  for (const std::size_t v : nearest_to_front(chart, quantity, cost, Whose::ours))
    (named.size() < least || (others.empty() && chart.variants[v].method == automatic) ? named : grey)
        .push_back(v);
  const std::size_t on_front = count_on_front(chart, quantity, cost, Whose::others);
  std::vector<std::size_t> later;
  std::set<std::string> programs;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const bool first = programs.insert(program_of(chart.variants[others[i]])).second;
    (first || i < on_front ? named : later).push_back(others[i]);
  }
  for (const std::size_t v : later) (named.size() < most_named ? named : grey).push_back(v);
  return {named, grey};
}

Plot plot_of(const WorkPrecision& chart, const ErrorMeasure& quantity, const Cost& cost) {
  Plot plot;
  plot.title = fmt::format("{}: {} against {}", chart.scene, quantity.title, cost.title);
  plot.x = {.label = cost.axis, .logarithmic = true};
  plot.y = {.label = quantity.axis, .logarithmic = true};
  auto [order, grey] = named_and_grey(chart, quantity, cost);
  const std::size_t named = order.size();
  const bool beside_others = chart.variants.size() > 0 && chart.variants.back().other;
  std::size_t numbered = 0;
  order.insert(order.end(), grey.begin(), grey.end());
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    Curve curve{.name = name_of(chart.variants[order[rank]]), .marks = true, .faint = rank >= named};
    for (const WorkPrecisionPoint& p : chart.points) {
      if (p.variant != order[rank]) continue;
      if (!p.finished) {
        if (cost.of(p) > 0) plot.edge.push_back({cost.of(p), curve.name, failed_tip(chart, p)});
        continue;
      }
      const double size = quantity.of(chart, p);
      if (size > beyond) {
        plot.edge.push_back({cost.of(p), curve.name, tip(chart, p)});
        continue;
      }
      // results that are bitwise equal (zero error) are drawn at the lower edge
      curve.x.push_back(cost.of(p));
      curve.y.push_back(size == 0 ? 1e-17 : size);
      curve.tips.push_back(tip(chart, p));
      curve.hollow.push_back(!p.trusted);
    }
    if (std::none_of(curve.y.begin(), curve.y.end(), [](double y) { return std::isfinite(y); })) continue;
    if (curve.faint && numbered < most_numbered) curve.number = ++numbered;
    if (beside_others) curve.group = program_of(chart.variants[order[rank]]);
    plot.curves.push_back(std::move(curve));
  }
  const auto front = front_of(chart, quantity, cost, Whose::ours);
  Curve line{.name = beside_others ? "borelli's front" : "front of trusted runs", .broad = true};
  std::vector<std::string> best;  // from coarse to fine, without duplicates
  for (const WorkPrecisionPoint* p : front) {
    line.x.push_back(cost.of(*p));
    line.y.push_back(std::max(quantity.of(chart, *p), 1e-17));
    if (const std::string name = name_of(chart.variants[p->variant]);
        std::find(best.begin(), best.end(), name) == best.end())
      best.push_back(name);
  }
  if (!front.empty()) plot.curves.insert(plot.curves.begin(), std::move(line));
  std::string words = front.empty() ? "No run is trusted." : "On the front, from coarse to fine: ";
  for (std::size_t i = 0; i < best.size(); ++i) words += (i > 0 ? "; " : "") + best[i];
  plot.notes = {words + (front.empty() ? "" : "."),
                "Empty dots: runs whose certificate is not trusted. Crosses above: runs that did not finish, "
                "or whose error exceeds 10" +
                    std::string(cost.of == milliseconds ? "" : " (without those that took too long)") + ".",
                chart.reference.words};
  if (quantity.of == of_contacts)
    plot.notes.insert(plot.notes.begin() + 1,
                      "Contacts: the largest of the errors of impact times (relative to the run's length), "
                      "momentum (relative to the largest), penetration (relative to the scene's length) and "
                      "energy (relative to the energy turnover).");
  if (beside_others)
    plot.notes.push_back(
        "Curves named after a program are that program's runs of the same scene in the same process; the "
        "others are ours. Ours include the cost of their certificate; the energies of others are evaluated "
        "at the outputs only.");
  return plot;
}

bool has(const WorkPrecision& chart, const ErrorMeasure& quantity) {
  return std::any_of(chart.points.begin(), chart.points.end(), [&](const auto& p) {
    const double error = quantity.of(chart, p);
    return p.finished && std::isfinite(error) && error > 0;
  });
}

}  // namespace

std::vector<Recommendation> recommendations(const WorkPrecision& chart) {
  std::vector<Recommendation> out;
  for (int digits = 1; digits <= 14; ++digits) {
    const WorkPrecisionPoint* p = fastest_within(chart, std::pow(10., -digits));
    if (!p) break;
    out.push_back({digits, p});
  }
  return out;
}

std::vector<FrontRow> front_against_front(const WorkPrecision& chart) {
  std::vector<FrontRow> out;
  for (int digits = 1; digits <= 10; ++digits) {
    const double error = std::pow(10., -digits);
    out.push_back({digits, fastest_within(chart, error), fastest_within(chart, error, Whose::others)});
  }
  return out;
}

std::string front_table(const WorkPrecision& chart) {
  std::string out =
      "| error | ours: ms | by | best other: ms | by | other / ours |\n| --- | ---: | --- | ---: | --- | "
      "---: "
      "|\n";
  const bool alone = chart.variants.empty() || !chart.variants.back().other;
  const auto cells = [&](const WorkPrecisionPoint* p, bool absent) {
    if (absent) return std::string("no method applies | ");
    return p ? fmt::format("{:.3g} | {}, {}", milliseconds(*p), name_of(chart.variants[p->variant]),
                           setting_words(chart, *p))
             : std::string("not within the time limit | ");
  };
  for (const FrontRow& row : front_against_front(chart)) {
    if (!row.ours && !row.other) continue;
    out += fmt::format(
        "| 1e-{} | {} | {} | {} |\n", row.digits, cells(row.ours, false), cells(row.other, alone),
        row.ours && row.other ? fmt::format("{:.3g}", row.other->seconds / row.ours->seconds) : "");
  }
  return out;
}

std::vector<std::pair<std::string, Plot>> work_precision_plots(const WorkPrecision& chart) {
  std::vector<std::pair<std::string, Plot>> out;
  for (const ErrorMeasure& quantity : quantities)
    for (const Cost& cost : costs)
      if (has(chart, quantity))
        out.emplace_back(fmt::format("{}_{}", quantity.file, cost.file), plot_of(chart, quantity, cost));
  return out;
}

std::string why_no_drawing(const WorkPrecision& chart) {
  if (std::any_of(std::begin(quantities), std::end(quantities),
                  [&](const ErrorMeasure& quantity) { return has(chart, quantity); }))
    return "";
  return std::any_of(chart.points.begin(), chart.points.end(), [](const auto& p) { return p.finished; })
             ? "Nothing is drawn: every finished run has zero error, as in a scene at rest."
             : "Nothing is drawn: no run finished.";
}

std::string work_precision_csv(const WorkPrecision& chart) {
  std::string out = plain_comment("# " + chart.reference.words) +
                    "\nmethod,equations,constraints,setting,finished,trusted,seconds,evaluations,position,"
                    "orientation_rad,energy,constraint,impacts_s,momentum,reason\n";
  for (const WorkPrecisionPoint& p : chart.points) {
    const Variant& v = chart.variants[p.variant];
    out += fmt::format("{},{},{},{:.17g},{},{},{:.6g},{}", v.method,
                       v.other                              ? "its own"
                       : v.equations == Equations::lagrange ? "lagrange"
                                                            : "recursive",
                       !chart.has_constraints                            ? "none"
                       : v.other                                         ? "its own"
                       : v.constraints == ConstraintTreatment::baumgarte ? "baumgarte"
                                                                         : "projection",
                       p.setting, p.finished ? 1 : 0, p.trusted ? 1 : 0, p.seconds, p.evaluations);
    const RunErrors& e = p.errors;
    for (const double error : {e.position, e.orientation, e.energy, e.constraint, e.impacts, e.momentum})
      out += p.finished && std::isfinite(error) ? fmt::format(",{:.17g}", error) : ",";
    out += "," + csv_text(p.reason) + "\n";
  }
  return out;
}

namespace {

std::string recommended_table(const WorkPrecision& chart) {
  const auto take = recommendations(chart);
  if (take.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const auto& [digits, p] : take)
    rows.push_back({fmt::format("10<sup>−{}</sup>", digits), html_text(name_of(chart.variants[p->variant])),
                    setting_words(chart, *p), fmt::format("{:.4g}", milliseconds(*p)),
                    fmt::format("{}", p->evaluations), fmt::format("{:.1e}", judged_error(chart, *p))});
  return "<section><h2>Recommended methods</h2>\n" +
         page_table("",
                    {{"for an error of"},
                     {"method"},
                     {"at"},
                     {"time (ms)", PageColumn::Kind::number},
                     {"evaluations", PageColumn::Kind::number},
                     {"its error", PageColumn::Kind::number}},
                    rows) +
         fmt::format(
             "<p>The fastest trusted run of those made; {}. Each method was run from coarse to fine "
             "settings, until a run took longer than the limit or two finer ones brought no "
             "gain.</p></section>\n",
             chart.has_impacts
                 ? "errors are the largest of the errors of impact times (relative to the run's "
                   "length), momentum, penetration (relative to the scene's length) and energy"
                 : "errors are the larger of position and orientation");
}

/// A table of the numbers of all charts, to the digits that the tips show.
std::string runs_table(const WorkPrecision& chart) {
  std::vector<PageColumn> titles{{"method"},
                                 {"at"},
                                 {"time (ms)", PageColumn::Kind::number},
                                 {"evaluations", PageColumn::Kind::number},
                                 {"trusted"}};
  std::vector<const ErrorMeasure*> measures;
  for (const ErrorMeasure& measure : quantities)
    if (has(chart, measure)) {
      measures.push_back(&measure);
      titles.push_back({measure.title, PageColumn::Kind::number});
    }
  std::vector<std::vector<std::string>> rows;
  for (const WorkPrecisionPoint& p : chart.points) {
    if (!p.finished) continue;
    rows.push_back({html_text(name_of(chart.variants[p.variant])), setting_words(chart, p),
                    fmt::format("{:.4g}", milliseconds(p)), fmt::format("{}", p.evaluations),
                    p.trusted ? "yes" : "no"});
    for (const ErrorMeasure* measure : measures) {
      const double error = measure->of(chart, p);
      rows.back().push_back(std::isfinite(error) ? fmt::format("{:.2g}", error) : "–");
    }
  }
  return fmt::format("<details class=\"runs\"><summary>All {} finished runs</summary>\n{}</details>\n",
                     rows.size(), page_table("", titles, rows));
}

std::string failed_table(const WorkPrecision& chart) {
  std::vector<std::vector<std::string>> rows;
  for (const WorkPrecisionPoint& p : chart.points)
    if (!p.finished)
      rows.push_back(
          {html_text(name_of(chart.variants[p.variant])), setting_words(chart, p), html_text(p.reason)});
  if (rows.empty()) return "";
  return "<section><h2>Runs that did not finish</h2>\n" +
         page_table("", {{"method"}, {"at"}, {"why", PageColumn::Kind::words}}, rows) + "</section>\n";
}

}  // namespace

std::string work_precision_page(const WorkPrecision& chart, const std::vector<std::string>& warnings) {
  ChartPage page{.title = chart.scene + ": work and precision",
                 .heading = chart.scene + ": cost of accuracy",
                 .warnings = warnings};
  page.sentences = {
      chart.reference.words,
      fmt::format("Position errors are relative to the scene's length, {:.4g} m: the longest length in the "
                  "scene (placements, gravity centres with radii of gyration, springs, distances).",
                  chart.length)};
  if (chart.share < 1)
    page.sentences.insert(
        page.sentences.begin(),
        fmt::format("Coarse runs only, of at most {:.0f} % of the time that a run may take: "
                    "finer ones follow.",
                    100 * chart.share));
  if (const std::string why = why_no_drawing(chart); !why.empty()) page.sentences.push_back(why);
  PageButtons errors{"error", "Error", {}}, spent{"cost", "Cost", {}};
  for (const ErrorMeasure& q : quantities) {
    if (!has(chart, q)) continue;
    errors.values.emplace_back(q.file, q.title);
    for (const Cost& c : costs)
      page.plots.push_back({{{"error", q.file}, {"cost", c.file}}, plot_of(chart, q, c)});
  }
  for (const Cost& c : costs) spent.values.emplace_back(c.file, c.title);
  if (!page.plots.empty()) page.buttons = {errors, spent};
  page.body = recommended_table(chart) + failed_table(chart) + runs_table(chart);
  return chart_page(page);
}

std::vector<std::string> work_precision_files() {
  std::vector<std::string> names;
  for (const ErrorMeasure& quantity : quantities)
    for (const Cost& cost : costs) names.push_back(fmt::format("{}_{}", quantity.file, cost.file));
  std::vector<std::string> out = plot_files(names);
  out.insert(out.end(), {"chart.csv", "chart.html"});
  return out;
}

Result<void> write_work_precision(const WorkPrecision& chart, const std::filesystem::path& folder,
                                  const std::vector<std::string>& warnings) {
  if (auto done = write_whole(folder / "chart.csv", work_precision_csv(chart)); !done) return done;
  if (auto done = write_plots(work_precision_plots(chart), folder); !done) return done;
  return write_whole(folder / "chart.html", work_precision_page(chart, warnings));
}

}  // namespace borelli
