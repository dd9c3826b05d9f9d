// A human dropped on the floor for 5 s by Moreau's time stepping, at several steps and from twelve heights.
// It is human_floor.toml, then the same human as MJCF (human_contact.xml, if present), or the named files.
// One fall is one iteration. Counters: median, least and most processor time of a fall (s); mean accepted and
// rejected steps (`in_vain`); the deepest overlap (m); `energy`, the largest error of the energy balance or
// of the contacts' energy, as a share of the energy turned over; `moved`, the largest energy change by
// separating overlaps (J); `momentum`, the largest horizontal momentum with a frictionless floor, exactly 0
// in theory (kg m/s); and the number of trusted falls. The label says why a fall is not trusted.
#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <vector>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

constexpr int starts = 12;  // each 1 mm higher; such near falls end in different heaps

/// The largest horizontal momentum without friction, kg m/s (the start has none); NaN where the run fails.
double stray_momentum(Scene scene, const SimulationSettings& settings) {
  for (Constraint& constraint : scene.constraints)
    std::visit(
        [](auto& kind) {
          if constexpr (requires { kind.surface; }) kind.surface.friction = 0;
        },
        constraint.kind);
  const auto system = compile(scene);
  const auto run = simulate(*system, system->initial, settings);
  return run ? run->linear_momentum.leftCols<2>().rowwise().norm().maxCoeff() : std::nan("");
}

void fall(benchmark::State& bench, const std::string& path, double step) {
  auto model = read_model(path);
  if (!model) return bench.SkipWithError(model.error().message().c_str());
  model->scene.simulation.end_time = 5;
  const auto system = compile(model->scene);
  if (!system) return bench.SkipWithError(system.error().message().c_str());
  SimulationSettings settings = system->settings;
  settings.step = step;
  settings.output_interval = 0.02;
  std::vector<double> times;
  double overlap = 0, energy = 0, moved = 0, steps = 0, rejected = 0, trusted = 0;
  std::string first_reason;
  for (auto _ : bench) {
    State start = system->initial;
    start.q[2] += 1e-3 * double(times.size());
    const std::clock_t begin = std::clock();
    auto motion = simulate(*system, start, settings);
    times.push_back(double(std::clock() - begin) / CLOCKS_PER_SEC);
    std::string reason = motion ? "" : motion.error().what;
    if (motion) {
      judge_passing(model->without_contact, *motion);
      const Certificate& c = motion->certificate;
      for (const ConstraintResidual& residual : c.residuals) overlap = std::max(overlap, residual.position);
      moved = std::max(moved, c.work_projection_size);
      energy = std::max(energy, std::max(c.energy_drift, c.contact_error) / c.energy_turnover);
      steps += double(c.steps_accepted) / starts;
      rejected += double(c.steps_rejected) / starts;
      trusted += c.trusted;
      if (!c.trusted) reason = c.reason;
    }
    if (first_reason.empty()) first_reason = reason;
  }
  std::sort(times.begin(), times.end());
  bench.counters["median"] = times[times.size() / 2];
  bench.counters["least"] = times.front();
  bench.counters["most"] = times.back();
  bench.counters["steps"] = steps;
  bench.counters["in_vain"] = rejected;
  bench.counters["overlap"] = overlap;
  bench.counters["energy"] = energy;
  bench.counters["moved"] = moved;
  bench.counters["momentum"] = stray_momentum(model->scene, settings);
  bench.counters["trusted"] = trusted;
  bench.SetLabel(first_reason);
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  benchmark::Initialize(&argc, argv);
  std::vector<std::string> files(argv + 1, argv + argc);
  if (files.empty()) {
    files = {test::source_folder() + "/tests/bench/human_floor.toml"};
    const std::string model = test::shared_folder() + "/models/bench/human_contact.xml";
    if (std::filesystem::exists(model)) files.push_back(model);
  }
  for (const std::string& file : files)
    for (const double step : {1e-2, 5e-3, 2e-3, 1e-3})
      benchmark::RegisterBenchmark(
          fmt::format("{}/{:g}ms", std::filesystem::path(file).filename().string(), 1e3 * step).c_str(), fall,
          file, step)
          ->Iterations(starts)
          ->Unit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
}
