// The human dropped on the floor (human_floor.toml, 5 s) by Moreau's time stepping at several steps:
// processor time (median of 7) and real-time factor, deepest overlap, error of the energy balance, what
// putting apart moved, and how far a frictionless floor lets the horizontal momentum stray, which it cannot
// change.
#include <fmt/core.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "dynamics/model_file.hpp"
#include "dynamics/simulate.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

double median_time(const System& system, const SimulationSettings& settings) {
  std::vector<double> times;
  for (int i = 0; i < 7; ++i) {
    const std::clock_t start = std::clock();
    if (!simulate(system, system.initial, settings)) return 0;
    times.push_back(double(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::nth_element(times.begin(), times.begin() + 3, times.end());
  return times[3];
}

/// The largest horizontal momentum without friction, kg m/s (the start has none), or when the run ended.
std::string stray_momentum(Scene scene, const SimulationSettings& settings) {
  for (Constraint& constraint : scene.constraints)
    std::visit(
        [](auto& kind) {
          if constexpr (requires { kind.surface; }) kind.surface.friction = 0;
        },
        constraint.kind);
  const auto system = compile(scene);
  const auto run = simulate(*system, system->initial, settings);
  if (!run) return run.error().what;
  return fmt::format("{:.2g} kg m/s", run->linear_momentum.leftCols<2>().rowwise().norm().maxCoeff());
}

int run() {
  const auto model = read_model(test::source_folder() + "/tests/bench/human_floor.toml");
  if (!model) return fmt::print(stderr, "{}\n", model.error().message()), 2;
  const auto system = compile(model->scene);
  fmt::print(
      "step ms | ms | real-time factor | overlap mm | energy | put apart J | stray momentum | verdict\n");
  for (const double step : {5e-3, 2e-3, 1e-3}) {
    SimulationSettings settings = system->settings;
    settings.step = step;
    settings.output_interval = 0.02;
    const double time = median_time(*system, settings);
    const auto path = simulate(*system, system->initial, settings);
    if (!path) return fmt::print(stderr, "{}\n", path.error().message()), 2;
    const Certificate& c = path->certificate;
    double deepest = 0;
    for (const ConstraintResidual& residual : c.residuals) deepest = std::max(deepest, residual.position);
    fmt::print("{:g} | {:.1f} | {:.0f} | {:.3f} | {:.2f} % | {:.2f} | {} | {}\n", 1e3 * step, 1e3 * time,
               settings.end_time / time, 1e3 * deepest, 100 * c.energy_drift / c.energy_turnover,
               c.work_projection_size, stray_momentum(model->scene, settings),
               c.trusted ? "trusted" : c.reason);
  }
  return 0;
}

}  // namespace
}  // namespace borelli

int main() { return borelli::run(); }
