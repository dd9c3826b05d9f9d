#include "pipeline/paper/shock_ratios.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/paper/paper_scenes.hpp"

namespace borelli {
namespace {

constexpr double most_evaluations = 4e6;

Scene with_cube_of(double mass, double end) {
  Scene scene = shock();
  scene.solids[0].shapes.at(0).mass = mass;
  scene.simulation.end_time = end;
  scene.simulation.output_interval = 0;
  return scene;
}

struct Cost {
  double evaluations, energy_error;
};

Result<Cost> cost_of(const System& system, SimulationSettings how) {
  const auto t = simulate(system, system.initial, how);
  if (!t) return tl::unexpected(t.error());
  double largest = 0;
  for (std::size_t i = 0; i < t->times.size(); ++i)
    largest = std::max(largest, std::abs(t->kinetic[i] + t->potential[i] - t->kinetic[0] - t->potential[0]));
  return Cost{static_cast<double>(t->certificate.evaluations), largest};
}

Result<double> evaluations_at(const System& system, SimulationSettings how, double energy_error) {
  const bool adaptive = method_is_adaptive(how.method);
  how.step = adaptive ? 1e-3 : 1e-2;
  how.tolerance = 1e-2;
  std::optional<Cost> before;
  while (true) {
    const auto now = cost_of(system, how);
    // a run with steps too coarse for the shock may fail
    const bool went = now.has_value();
    if (!went && (adaptive ? how.tolerance < 1e-9 : how.step < 1e-5)) return tl::unexpected(now.error());
    if (went && now->energy_error <= energy_error) {
      if (!before) return now->evaluations;
      const double share =
          std::log(before->energy_error / energy_error) / std::log(before->energy_error / now->energy_error);
      return std::exp(std::log(before->evaluations) +
                      share * std::log(now->evaluations / before->evaluations));
    }
    if (went && now->evaluations > most_evaluations) return std::numeric_limits<double>::quiet_NaN();
    before = went ? std::optional(*now) : std::nullopt;
    (adaptive ? how.tolerance : how.step) /= adaptive ? std::sqrt(10.) : 2;
  }
}

}  // namespace

Result<std::vector<ShockRatio>> shock_ratios(const ShockRatioSettings& settings) {
  std::vector<ShockRatio> out;
  for (const double mass : settings.mass_ratios) {
    const Scene scene = with_cube_of(mass, settings.end);
    const auto system = compile(scene);
    if (!system) return tl::unexpected(system.error());
    ShockRatio row{mass, {}};
    for (const char* method : shock_methods) {
      SimulationSettings how = scene.simulation;
      how.method = method;
      const auto count = evaluations_at(*system, how, settings.energy_error * mass * 9.81);
      if (!count)
        return failure(fmt::format("{} at a mass ratio of {:g}", method, mass), count.error().message());
      row.evaluations.push_back(*count);
    }
    out.push_back(std::move(row));
  }
  return out;
}

}  // namespace borelli
