#include "pipeline/paper/paper_figures.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/work_precision.hpp"
#include "pipeline/paper/paper_scenes.hpp"
#include "pipeline/paper/shock_ratios.hpp"

namespace borelli {
namespace {

Result<Trajectory> run(Scene scene, const std::string& method, double step, double tolerance, double end) {
  scene.simulation.method = method;
  scene.simulation.step = step;
  scene.simulation.tolerance = tolerance;
  scene.simulation.end_time = end;
  scene.simulation.output_interval = 0;
  return compile(scene).and_then([](const System& system) { return simulate(system); });
}

std::vector<double> total_energy(const Trajectory& t) {
  std::vector<double> total;
  for (std::size_t i = 0; i < t.times.size(); ++i) total.push_back(t.kinetic[i] + t.potential[i]);
  return total;
}

std::string verdict(const Trajectory& t) {
  const std::vector<double> total = total_energy(t);
  double strays = 0;
  for (const double e : total) strays = std::max(strays, std::abs(e - total.front()));
  const Certificate& c = t.certificate;
  const std::string text = fmt::format(
      "The total energy deviates by at most {:.3g} J from its start, with an energy turnover of {:.4g} J; "
      "the run's certificate ",
      strays, c.energy_turnover);
  return text + (c.trusted ? "trusts it." : "marks it UNTRUSTED: " + c.reason + ".");
}

Plot energies(const std::string& title, const Trajectory& t) {
  Plot plot{title, {"time (s)"}, {"energy (J)"}, {}, {verdict(t)}};
  plot.x.low = 0, plot.x.high = t.times.back();
  plot.curves = {{"kinetic energy", t.times, t.kinetic},
                 {"total energy", t.times, total_energy(t)},
                 {"potential energy", t.times, t.potential}};
  return plot;
}

// Drift of the total energy, which is invisible at the scale of the energy figures.
Plot straying(const std::string& title, const std::vector<std::pair<std::string, const Trajectory*>>& runs) {
  Plot plot{title, {"time (s)"}, {"total energy - initial| (J)", true}, {}, {}};
  plot.x.low = 0, plot.x.high = runs.front().second->times.back();
  double largest = 0;
  for (const auto& [name, t] : runs) {
    Curve curve{name, t->times, total_energy(*t)};
    const double start = curve.y.front();
    for (double& e : curve.y) largest = std::max(largest, e = std::abs(e - start));
    plot.curves.push_back(std::move(curve));
    plot.notes.push_back(
        fmt::format("{}: {} evaluations of the equations.", name, t->certificate.evaluations));
  }
  plot.y.low =
      std::pow(10, std::floor(std::log10(largest)) - 8);  // a curve is lower only where it crosses zero
  return plot;
}

Plot step_sizes(const std::string& title, const Trajectory& t) {
  Plot plot{
      title, {"time (s)"}, {"step size (s)", true}, {{"accepted steps", t.step_times, t.step_sizes}}, {}};
  plot.x.low = 0, plot.x.high = t.times.back();
  const Certificate& c = t.certificate;
  plot.notes = {
      fmt::format("{} steps accepted, {} rejected, {} evaluations of the equations; the smallest step is "
                  "{:.3g} s, at {:.4g} s.",
                  c.steps_accepted, c.steps_rejected, c.evaluations, c.smallest_step, c.smallest_step_time)};
  return plot;
}

// Cost of the shock against the mass ratio.
Result<Plot> shock_costs(const ShockRatioSettings& s) {
  const auto rows = shock_ratios(s);
  if (!rows) return tl::unexpected(rows.error());
  Plot plot{"Besides figures 6 to 8: what the shock costs",
            {"mass of cube over bar", true},
            {"evaluations of the equations", true},
            {},
            {}};
  std::size_t number = 0;
  for (const char* method : shock_methods) {
    Curve curve{method};
    curve.marks = true;
    for (const ShockRatio& row : *rows) {
      curve.x.push_back(row.mass_ratio);
      curve.y.push_back(row.evaluations[number]);
    }
    plot.curves.push_back(std::move(curve));
    ++number;
  }
  std::string ratios;
  for (const ShockRatio& row : *rows) {
    const double ratio = row.evaluations[0] / row.evaluations[1];
    ratios += fmt::format("{}{:.{}f} at {:g}", ratios.empty() ? "" : ", ", ratio, ratio < 10 ? 1 : 0,
                          row.mass_ratio);
  }
  plot.notes = {
      fmt::format("{:g} s; the total energy deviates by {:g} of the energy that the cube gains in falling by "
                  "the bar's length.",
                  s.end, s.energy_error),
      "Evaluations of rk4 with fixed steps over those of the paper's adaptive method: " + ratios + "."};
  return plot;
}

// Median processor time of a whole simulation, from compiled scene to trajectory, one row per 0.1 s.
Result<double> cost(Scene scene, const std::string& method, const PaperFigureSettings& s) {
  scene.simulation.method = method;
  scene.simulation.step = 0.001;
  scene.simulation.tolerance = s.tolerance;
  scene.simulation.end_time = s.bars_end;
  scene.simulation.output_interval = 0.1;
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  std::vector<double> times;
  for (int i = 0; i < s.repeats; ++i) {
    const double start = processor_time();
    if (const auto t = simulate(*system); !t) return tl::unexpected(t.error());
    times.push_back(processor_time() - start);
  }
  std::nth_element(times.begin(), times.begin() + s.repeats / 2, times.end());
  return times[static_cast<std::size_t>(s.repeats / 2)];
}

Result<Plot> execution_times(const PaperFigureSettings& s) {
  Plot plot{"Figure 10: execution time against n", {"n"}, {"CPU time (s)", true}, {}, {}};
  plot.x.whole_numbers = true;
  struct Row {
    const char* name;
    Scene (*scene)(int);
    const char* method;
  };
  const Row rows[] = {{"n independent bars, RK4, dt 0.001 s", bars, "rk4"},
                      {"n independent bars, adaptive RK4", bars, "rk4_adaptive"},
                      {"n-pendulum, RK4, dt 0.001 s", pendulum, "rk4"},
                      {"n-pendulum, adaptive RK4", pendulum, "rk4_adaptive"}};
  for (const Row& row : rows) {
    Curve curve{row.name};
    curve.marks = true;
    for (const int n : s.counts) {
      const auto seconds = cost(row.scene(n), row.method, s);
      if (!seconds) return tl::unexpected(seconds.error());
      curve.x.push_back(n);
      curve.y.push_back(*seconds);
    }
    plot.curves.push_back(std::move(curve));
  }
  plot.notes = {fmt::format(
      "{:g} s of motion, all bars level at the start; adaptive: tolerance {:g}. CPU time of one thread of "
      "the machine that drew this, median of {} runs.",
      s.bars_end, s.tolerance, s.repeats)};
  return plot;
}

}  // namespace

Result<std::vector<PaperFigure>> paper_figures(const PaperFigureSettings& s,
                                               const std::function<void(const std::string&)>& begins) {
  std::vector<PaperFigure> out;
  const auto in_figure = [](const char* name, const Error& error) {
    return tl::unexpected(Error{name, error.message(), error.kind});
  };
  struct Row {
    const char *name, *method, *title;
  };
  const Row rows[] = {{"figure_2", "euler", "Figure 2: roundabout, Euler, dt = 0.01 s"},
                      {"figure_3", "rk2", "Figure 3: roundabout, Runge-Kutta 2, dt = 0.01 s"},
                      {"figure_4", "rk4", "Figure 4: roundabout, Runge-Kutta 4, dt = 0.01 s"}};
  std::vector<Trajectory> turns;
  for (const Row& row : rows) {
    begins(row.name);
    auto t = run(roundabout(), row.method, 0.01, s.tolerance, s.roundabout_end);
    if (!t) return in_figure(row.name, t.error());
    out.push_back({row.name, energies(row.title, *t)});
    turns.push_back(std::move(*t));
  }
  out.push_back(
      {"figures_2_3_4_drift",
       straying("Besides figures 2 to 4: deviation of the total energy",
                {{"Euler", &turns[0]}, {"Runge-Kutta 2", &turns[1]}, {"Runge-Kutta 4", &turns[2]}})});

  begins("figure_6");
  const auto fixed = run(shock(), "rk4", s.shock_step, s.tolerance, s.shock_end);
  if (!fixed) return in_figure("figure_6", fixed.error());
  out.push_back({"figure_6",
                 energies(fmt::format("Figure 6: shock, Runge-Kutta 4, dt = {:g} s", s.shock_step), *fixed)});
  begins("figure_7");
  const auto adaptive = run(shock(), "rk4_adaptive", 1e-3, s.tolerance, s.shock_end);
  if (!adaptive) return in_figure("figure_7", adaptive.error());
  out.push_back({"figure_7", energies("Figure 7: shock, adaptive Runge-Kutta 4", *adaptive)});
  out.push_back({"figure_8", step_sizes("Figure 8: shock, step size of adaptive Runge-Kutta 4", *adaptive)});
  out.push_back(
      {"figures_6_7_drift", straying("Besides figures 6 and 7: deviation of the total energy",
                                     {{fmt::format("Runge-Kutta 4, dt = {:g} s", s.shock_step), &*fixed},
                                      {"adaptive Runge-Kutta 4", &*adaptive}})});

  begins("figures_6_7_8_cost");
  const auto costs = shock_costs(s.shock_ratios);
  if (!costs) return in_figure("figures_6_7_8_cost", costs.error());
  out.push_back({"figures_6_7_8_cost", *costs});

  begins("figure_10");
  const auto times = execution_times(s);
  if (!times) return in_figure("figure_10", times.error());
  out.push_back({"figure_10", *times});
  return out;
}

}  // namespace borelli
