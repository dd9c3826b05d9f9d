#include "pipeline/charts/long_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/equations/momentum.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/chart_page.hpp"

namespace borelli {
namespace {

constexpr long drift_rows = 1000;

double mean(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += values[i];
  return sum / double(end - begin);
}

/// Largest change since the start of the conserved momenta, over their size, by row.
std::vector<double> momentum_errors(const System& system, const Trajectory& t) {
  const auto momenta = conserved_momenta(system, system.parameters);
  std::vector<double> out;
  if (momenta.empty()) return out;
  Kinematics kinematics(system);
  std::vector<Eigen::Vector3d> starts;
  std::vector<double> scales(momenta.size(), 0);
  for (std::size_t row = 0; row < t.times.size(); ++row) {
    const Eigen::VectorXd q = t.q.row(Eigen::Index(row)), v = t.v.row(Eigen::Index(row));
    update_kinematics(system, system.parameters, t.times[row], q.data(), v.data(), kinematics);
    double worst = 0;
    for (std::size_t i = 0; i < momenta.size(); ++i) {
      const MomentumValue now = momentum_value(momenta[i], system.parameters, kinematics);
      if (row == 0) starts.push_back(now.value);
      scales[i] = std::max(scales[i], now.scale);
      if (scales[i] > 0) worst = std::max(worst, (now.value - starts[i]).norm() / scales[i]);
    }
    out.push_back(worst);
  }
  return out;
}

/// `rounding`: a change that rounding alone may make over the run.
void judge_energy(LongRun& run, double rounding) {
  const std::size_t count = run.energy.size(), quarter = count / 4;
  if (quarter == 0) return;
  const auto [low, high] = std::minmax_element(run.energy.begin(), run.energy.begin() + long(quarter));
  run.swing = *high - *low;
  const double change = mean(run.energy, count - quarter, count) - mean(run.energy, 0, quarter);
  run.drift = change / (mean(run.times, count - quarter, count) - mean(run.times, 0, quarter));
  if (std::abs(change) <= rounding) return;
  run.secular = std::abs(change) > run.swing;
  // A drift smaller than the swing is still secular if the means of all eighths are monotone (by chance in
  // one of 20000 runs) and the change exceeds the random part of the swing's mean.
  if (count < 16 || run.secular) return;
  const auto eighth = [&](std::size_t i) { return mean(run.energy, i * count / 8, (i + 1) * count / 8); };
  bool ordered = std::abs(change) > run.swing / std::sqrt(double(count) / 8);
  for (std::size_t i = 1; i < 8; ++i)
    ordered = ordered && (change > 0 ? eighth(i) > eighth(i - 1) : eighth(i) < eighth(i - 1));
  run.secular = ordered;
}

LongRun one_run(const System& system, SimulationSettings how, long steps) {
  LongRun out{.method = how.method};
  const bool adaptive = method_is_adaptive(how.method);
  Observer observer;
  long made = 0;
  observer.progress = [&](double) { return !adaptive || ++made < steps; };
  const auto t = simulate(system, system.initial, how, observer);
  if (!t) {
    out.reason = t.error().message();
    return out;
  }
  if (t->times.back() < how.end_time * (1 - 1e-12))
    out.reason = fmt::format("stopped after {} steps at t = {:.6g} s", steps, t->times.back());
  out.evaluations = t->certificate.evaluations;
  out.times = t->times;
  const double turnover = t->certificate.energy_turnover > 0 ? t->certificate.energy_turnover : 1;
  for (std::size_t i = 0; i < t->times.size(); ++i)
    out.energy.push_back((t->kinetic[i] + t->potential[i] - t->work[i] - t->kinetic[0] - t->potential[0]) /
                         turnover);
  out.momentum = momentum_errors(system, *t);
  double largest = 0;
  for (std::size_t i = 0; i < t->times.size(); ++i)
    largest = std::max(largest, std::abs(t->kinetic[i]) + std::abs(t->potential[i]));
  // one rounding of the energies a step
  judge_energy(out, double(steps) * std::numeric_limits<double>::epsilon() * largest / turnover);
  return out;
}

Curve curve_of(const LongRun& run, const std::vector<double>& values) {
  Curve curve{.name = run.method};
  for (std::size_t i = 1; i < values.size(); ++i) {  // no error at the start
    curve.x.push_back(run.times[i]);
    // zero errors are drawn at the lower edge
    curve.y.push_back(std::max(std::abs(values[i]), 1e-17));
  }
  return curve;
}

std::string verdict(const LongRun& run) {
  if (run.energy.empty()) return "failed";
  if (run.secular) return run.drift > 0 ? "gains" : "loses";
  return run.large() ? "off by more than a tenth" : "bounded";
}

}  // namespace

Result<LongRuns> long_runs(const Scene& scene, const LongRunSettings& settings,
                           const std::function<void(double)>& progress) {
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  if (settings.steps < 8) return bad_use("long runs", "need at least 8 steps");
  SimulationSettings how = scene.simulation;
  how.accuracy = 0;
  how.equations = settings.equations;
  if (settings.step > 0) how.step = settings.step;
  if (settings.tolerance > 0) how.tolerance = settings.tolerance;
  const long between = std::max(1L, settings.steps / drift_rows), count = settings.steps / between;
  how.output_interval = double(between) * how.step;
  how.end_time = system->initial.t + double(count) * how.output_interval;
  LongRuns out{scene.name, how.step, how.end_time, {}};
  const std::vector<std::string> methods = settings.methods.empty() ? integrator_names() : settings.methods;
  for (std::size_t i = 0; i < methods.size(); ++i) {
    how.method = methods[i];
    out.runs.push_back(one_run(*system, how, settings.steps));
    progress(double(i + 1) / double(methods.size()));
  }
  return out;
}

std::vector<std::pair<std::string, Plot>> long_run_plots(const LongRuns& runs) {
  std::vector<std::pair<std::string, Plot>> out;
  const std::string note =
      fmt::format("Steps of {:.4g} s, {:.4g} in all; adaptive methods cover the same time.", runs.step,
                  runs.end / runs.step);
  const auto add = [&](const char* file, const std::string& title, const char* label, auto&& wanted,
                       const std::vector<double> LongRun::*values) {
    Plot plot{.title = runs.scene + ": " + title,
              .x = {.label = "time (s)"},
              .y = {.label = label, .logarithmic = true},
              .curves = {},
              .notes = {note}};
    for (const LongRun& run : runs.runs)
      if (wanted(run) && !(run.*values).empty()) plot.curves.push_back(curve_of(run, run.*values));
    if (!plot.curves.empty()) out.emplace_back(file, std::move(plot));
  };
  add(
      "energy_secular", "energy, methods whose errors accumulate", "energy error / energy turnover",
      [](const LongRun& run) { return run.secular; }, &LongRun::energy);
  add(
      "energy_bounded", "energy, methods whose errors stay bounded", "energy error / energy turnover",
      [](const LongRun& run) { return !run.secular; }, &LongRun::energy);
  add(
      "momentum", "momenta that the scene conserves", "momentum error / momentum",
      [](const LongRun&) { return true; }, &LongRun::momentum);
  return out;
}

std::string long_runs_page(const LongRuns& runs, const std::vector<std::string>& warnings) {
  ChartPage page{.title = runs.scene + ": long runs",
                 .heading = runs.scene + ": energy and momentum over long runs",
                 .warnings = warnings,
                 .sentences = {fmt::format("{:.4g} steps of {:.4g} s.", runs.end / runs.step, runs.step)}};
  PageButtons which{"series", "Chart", {}};
  for (auto& [name, plot] : long_run_plots(runs)) {
    which.values.emplace_back(name, name == "energy_secular"   ? "energy, accumulating"
                                    : name == "energy_bounded" ? "energy, bounded"
                                                               : "momentum");
    page.plots.push_back({{{"series", name}}, std::move(plot)});
  }
  page.buttons = {which};
  std::vector<std::vector<std::string>> rows;
  for (const LongRun& run : runs.runs)
    rows.push_back({run.method, verdict(run), fmt::format("{:.2g}", run.drift),
                    fmt::format("{:.2g}", run.swing), fmt::format("{}", run.evaluations),
                    html_text(run.reason)});
  page.body =
      "<section><h2>Drift</h2>\n" +
      page_table("",
                 {{"method"},
                  {"energy"},
                  {"drift (1/s)", PageColumn::Kind::number},
                  {"swing", PageColumn::Kind::number},
                  {"evaluations", PageColumn::Kind::number},
                  {"why not", PageColumn::Kind::words}},
                 rows) +
      "<p>Drift: from the mean of the run's first quarter to that of its last quarter. Swing: "
      "largest minus least value within the first quarter. An error accumulates (gains, loses) if the drift "
      "exceeds the swing, or if the means of the run's eighths rise or fall steadily. Otherwise it is "
      "bounded, or off by more than a tenth. All are relative to the energy turnover.</p></section>\n";
  return chart_page(page);
}

std::string long_runs_csv(const LongRuns& runs) {
  std::string out = "method,energy,drift_per_s,swing,evaluations,reason\n";
  for (const LongRun& run : runs.runs)
    out += fmt::format("{},{},{:.17g},{:.17g},{},{}\n", run.method, verdict(run), run.drift, run.swing,
                       run.evaluations, csv_text(run.reason));
  return out;
}

}  // namespace borelli
