#include "pipeline/work_precision_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/integrator.hpp"
#include "pipeline/chart_page.hpp"

namespace borelli {
namespace {

// curves that a drawing names; the others stand in grey behind them
constexpr std::size_t most_named = 10;

double error_of(const WorkPrecisionPoint& p) { return std::max(p.errors.position, p.errors.orientation); }
double milliseconds(const WorkPrecisionPoint& p) { return 1e3 * p.seconds; }
double evaluations(const WorkPrecisionPoint& p) { return double(p.evaluations); }

struct Quantity {
  const char *file, *title, *axis;
  double RunErrors::*error;
};

constexpr Quantity quantities[] = {
    {"position", "position", "largest error of position / scene's length", &RunErrors::position},
    {"orientation", "orientation", "largest error of orientation (rad)", &RunErrors::orientation},
    {"energy", "energy", "largest drift of energy / energy turned over", &RunErrors::energy},
    {"constraint", "constraints", "largest residual of a constraint (m or rad)", &RunErrors::constraint},
    {"impacts", "times of impacts", "largest error of an impact's time (s)", &RunErrors::impacts}};

struct Cost {
  const char *file, *title, *axis;
  double (*of)(const WorkPrecisionPoint&);
};

constexpr Cost costs[] = {{"time", "processor time", "processor time (ms)", milliseconds},
                          {"evaluations", "evaluations", "evaluations of the equations", evaluations}};

std::string setting_words(const WorkPrecision& chart, const WorkPrecisionPoint& p) {
  return method_is_adaptive(chart.variants[p.variant].method) ? fmt::format("tolerance {:.3g}", p.setting)
                                                              : fmt::format("step {:.4g} s", p.setting);
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
  if (!p.trusted) out += fmt::format("\nnot trusted: {}", p.reason);
  return out;
}

std::string failed_tip(const WorkPrecision& chart, const WorkPrecisionPoint& p) {
  return fmt::format("{}, {}\ndid not finish: {}", name_of(chart.variants[p.variant]),
                     setting_words(chart, p), p.reason);
}

// The variants that come nearest to the front, best first.
std::vector<std::size_t> nearest_to_front(const WorkPrecision& chart, const Cost& cost,
                                          double RunErrors::*error) {
  const auto front = pareto_front(chart, cost.of, [&](const auto& p) { return p.errors.*error; });
  std::vector<double> distance(chart.variants.size(), std::numeric_limits<double>::infinity());
  for (const WorkPrecisionPoint& p : chart.points) {
    if (!p.finished || !p.trusted || !std::isfinite(p.errors.*error)) continue;
    double best = std::numeric_limits<double>::infinity();
    for (const WorkPrecisionPoint* f : front)
      if (f->errors.*error <= p.errors.*error) best = std::min(best, cost.of(*f));
    if (std::isfinite(best)) distance[p.variant] = std::min(distance[p.variant], cost.of(p) / best);
  }
  std::vector<std::size_t> order(chart.variants.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return distance[a] < distance[b]; });
  return order;
}

Plot plot_of(const WorkPrecision& chart, const Quantity& quantity, const Cost& cost) {
  Plot plot;
  plot.title = fmt::format("{}: {} against {}", chart.scene, quantity.title, cost.title);
  plot.x = {.label = cost.axis, .logarithmic = true};
  plot.y = {.label = quantity.axis, .logarithmic = true};
  const auto order = nearest_to_front(chart, cost, quantity.error);
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    Curve curve{.name = name_of(chart.variants[order[rank]]), .marks = true, .faint = rank >= most_named};
    for (const WorkPrecisionPoint& p : chart.points) {
      if (p.variant != order[rank]) continue;
      if (!p.finished) {
        if (cost.of == milliseconds) plot.edge.push_back({milliseconds(p), curve.name, failed_tip(chart, p)});
        continue;
      }
      // what came out the same to the last bit (or was not off at all) stands at the foot of the chart
      const double size = p.errors.*quantity.error;
      curve.x.push_back(cost.of(p));
      curve.y.push_back(size == 0 ? 1e-17 : size);
      curve.tips.push_back(tip(chart, p));
      curve.hollow.push_back(!p.trusted);
    }
    if (std::any_of(curve.y.begin(), curve.y.end(), [](double y) { return std::isfinite(y); }))
      plot.curves.push_back(std::move(curve));
  }
  const auto front = pareto_front(chart, cost.of, [&](const auto& p) { return p.errors.*quantity.error; });
  Curve line{.name = "front of trusted runs", .broad = true};
  std::vector<std::string> best;  // from coarse to fine, each once
  for (const WorkPrecisionPoint* p : front) {
    line.x.push_back(cost.of(*p));
    line.y.push_back(std::max(p->errors.*quantity.error, 1e-17));
    if (const std::string name = name_of(chart.variants[p->variant]);
        std::find(best.begin(), best.end(), name) == best.end())
      best.push_back(name);
  }
  if (!front.empty()) plot.curves.insert(plot.curves.begin(), std::move(line));
  std::string words = front.empty() ? "No run is trusted." : "On the front, from coarse to fine: ";
  for (std::size_t i = 0; i < best.size(); ++i) words += (i > 0 ? "; " : "") + best[i];
  plot.notes = {
      words + (front.empty() ? "" : "."),
      "Empty dots: runs whose certificate is not trusted. Crosses above: runs that did not finish. Grey: "
      "farther from the front.",
      chart.reference.words};
  return plot;
}

bool has(const WorkPrecision& chart, double RunErrors::*error) {
  return std::any_of(chart.points.begin(), chart.points.end(), [&](const auto& p) {
    return p.finished && std::isfinite(p.errors.*error) && p.errors.*error > 0;
  });
}

}  // namespace

std::vector<Recommendation> recommendations(const WorkPrecision& chart) {
  std::vector<Recommendation> out;
  if (!chart.reference.found) return out;
  const auto front = pareto_front(chart, milliseconds, error_of);
  for (int digits = 1; digits <= 14; ++digits) {
    const auto first = std::find_if(front.begin(), front.end(),
                                    [&](const auto* p) { return error_of(*p) <= std::pow(10., -digits); });
    if (first == front.end()) break;
    out.push_back({digits, *first});
  }
  return out;
}

std::vector<std::pair<std::string, Plot>> work_precision_plots(const WorkPrecision& chart) {
  std::vector<std::pair<std::string, Plot>> out;
  for (const Quantity& quantity : quantities)
    for (const Cost& cost : costs)
      if (has(chart, quantity.error))
        out.emplace_back(fmt::format("{}_{}", quantity.file, cost.file), plot_of(chart, quantity, cost));
  return out;
}

std::string work_precision_csv(const WorkPrecision& chart) {
  std::string out = "# " + chart.reference.words +
                    "\nmethod,equations,constraints,setting,finished,trusted,seconds,evaluations,position,"
                    "orientation_rad,energy,constraint,impacts_s,reason\n";
  for (const WorkPrecisionPoint& p : chart.points) {
    const Variant& v = chart.variants[p.variant];
    out += fmt::format("{},{},{},{:.17g},{},{},{:.6g},{}", v.method,
                       v.equations == Equations::lagrange ? "lagrange" : "recursive",
                       !chart.has_constraints                            ? "none"
                       : v.constraints == ConstraintTreatment::baumgarte ? "baumgarte"
                                                                         : "projection",
                       p.setting, p.finished ? 1 : 0, p.trusted ? 1 : 0, p.seconds, p.evaluations);
    for (const Quantity& quantity : quantities)
      out += p.finished && std::isfinite(p.errors.*quantity.error)
                 ? fmt::format(",{:.17g}", p.errors.*quantity.error)
                 : ",";
    out += "," + csv_text(p.reason) + "\n";
  }
  return out;
}

std::string work_precision_page(const WorkPrecision& chart) {
  PageButtons errors{"error", {}}, spent{"cost", {}};
  for (const Quantity& q : quantities)
    if (has(chart, q.error)) errors.values.emplace_back(q.file, q.title);
  for (const Cost& c : costs) spent.values.emplace_back(c.file, c.title);
  std::string out;
  for (const Quantity& q : quantities)
    for (const Cost& c : costs)
      if (has(chart, q.error))
        out += fmt::format("<div class='plot' data-error='{}' data-cost='{}'>{}</div>\n", q.file, c.file,
                           svg(plot_of(chart, q, c)));
  if (const auto take = recommendations(chart); !take.empty()) {
    out +=
        "<h2>What to take</h2>\n<table><tr><th>for an error of</th><th>method</th><th>at</th>"
        "<th class='n'>ms</th><th class='n'>evaluations</th><th class='n'>its error</th></tr>\n";
    for (const auto& [digits, p] : take)
      out += fmt::format(
          "<tr><td>10<sup>−{}</sup></td><td>{}</td><td>{}</td><td class='n'>{:.3g}</td><td class='n'>{}</td>"
          "<td class='n'>{:.1e}</td></tr>\n",
          digits, name_of(chart.variants[p->variant]), setting_words(chart, *p), milliseconds(*p),
          p->evaluations, error_of(*p));
    out +=
        "</table>\n<p>The fastest trusted run of those made; errors are the larger of position and "
        "orientation.</p>\n";
  }
  std::string failed;
  for (const WorkPrecisionPoint& p : chart.points)
    if (!p.finished)
      failed += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                            name_of(chart.variants[p.variant]), setting_words(chart, p), html_text(p.reason));
  if (!failed.empty())
    out += "<h2>Runs that did not finish</h2>\n<table><tr><th>method</th><th>at</th><th>why</th></tr>\n" +
           failed + "</table>\n";
  return chart_page(chart.scene + ": work and precision", chart.scene + ": what accuracy costs",
                    {chart.reference.words}, {errors, spent}, out);
}

}  // namespace borelli
