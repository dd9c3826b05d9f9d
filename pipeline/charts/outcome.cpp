#include "pipeline/charts/outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/simulate.hpp"

namespace borelli {
namespace {

// rows of a run, for judging its energy in quarters
constexpr long energy_rows = 256;

constexpr const char* names[] = {"stable",  "inaccurate", "energy loss", "energy growth", "constraint drift",
                                 "blow-up", "not solved", "refused",     "unfinished"};

// the engine's messages about divergence: coordinates and velocities, accelerations (simulate, equations)
constexpr const char* runaway[] = {"has grown to", "no longer a finite number", "is not a finite number"};

Outcome of_error(const Error& error) {
  if (error.kind == Error::Kind::use) return Outcome::refused;
  for (const char* words : runaway)
    if (error.what.find(words) != std::string::npos) return Outcome::blow_up;
  return Outcome::not_solved;
}

double largest_residual(const Certificate& c) {
  double most = c.residuals.empty() ? std::numeric_limits<double>::quiet_NaN() : 0;
  for (const ConstraintResidual& r : c.residuals) most = std::max(most, r.position);
  return most;
}

/// Sets fixed steps and an output interval that is an exact multiple of the step.
void set_lengths(SimulationSettings& how, double start, const RunLengths& lengths) {
  const double wanted = std::ceil((how.end_time - start) / how.step - 1e-9);
  const long steps = long(std::clamp(wanted, double(lengths.least), double(lengths.most)));
  const long between = std::max(1L, steps / energy_rows);
  // at least to the scene's end, but within the largest number of steps
  const long count = (steps + (wanted > double(steps) ? 0 : between - 1)) / between;
  how.output_interval = double(between) * how.step;
  how.end_time = start + double(count) * how.output_interval;
}

/// Whether the energy itself (kinetic and potential) has a higher mean in the last quarter than in the one
/// before, by more than the work since plus `least`. An error that accumulates while dampers remove more is
/// not an instability.
bool rises(const Trajectory& t, std::size_t quarter, double least) {
  const std::size_t count = t.times.size(), half = count - 2 * quarter;
  double gain = 0, given = 0;
  for (std::size_t i = half; i < count; ++i) {
    gain += (i < half + quarter ? -1 : 1) * (t.kinetic[i] + t.potential[i]) / double(quarter);
    if (i > half) given += std::max(0., t.work[i] - t.work[i - 1]);
  }
  return gain > given + least;
}

}  // namespace

const char* name_of(Outcome outcome) { return names[int(outcome)]; }

std::vector<std::string> outcome_names() { return {std::begin(names), std::end(names)}; }

bool is_unstable(Outcome outcome) {
  return outcome == Outcome::energy_growth || outcome == Outcome::constraint_drift ||
         outcome == Outcome::blow_up || outcome == Outcome::not_solved;
}

Outcome judge(const System& system, const Trajectory& trajectory) {
  const Certificate& c = trajectory.certificate;
  if (c.trusted) return Outcome::stable;
  const std::size_t count = trajectory.times.size(), quarter = count / 4;
  const double limit = c.energy_threshold * c.energy_turnover;
  bool loses = false;
  if (c.energy_drift > limit && quarter > 0) {
    const auto balance = [&](std::size_t i) {
      return trajectory.kinetic[i] + trajectory.potential[i] - trajectory.work[i] - trajectory.kinetic[0] -
             trajectory.potential[0];
    };
    double early = 0, deepest = 0, least = std::numeric_limits<double>::infinity(), most = -least;
    for (std::size_t i = 0; i < count; ++i) {
      const double e = balance(i);
      if (i < quarter) early = std::max(early, std::abs(e));
      deepest = std::min(deepest, e);
      if (i >= count - quarter) least = std::min(least, e), most = std::max(most, e);
    }
    if (least > 1.2 * early && rises(trajectory, quarter, 0.1 * limit)) return Outcome::energy_growth;
    loses = deepest < 0 && most < 0.5 * deepest;
  }
  for (std::size_t i = 0; i < c.residuals.size(); ++i)
    if (c.residuals[i].position > c.energy_threshold * system.row_scale[system.constraints[i].first_row])
      return Outcome::constraint_drift;
  return loses ? Outcome::energy_loss : Outcome::inaccurate;
}

Tried try_run(const System& system, SimulationSettings how, double setting, const RunLengths& lengths) {
  const bool adaptive = method_is_adaptive(how.method);
  const double start = system.initial.t, wanted = how.end_time;
  how.accuracy = 0;
  (adaptive ? how.tolerance : how.step) = setting;
  if (adaptive)
    how.output_interval = (how.end_time - start) / double(energy_rows);
  else if (setting > 0)
    set_lengths(how, start, lengths);
  Observer observer;
  long steps = 0;
  bool stopped = false;
  observer.progress = [&](double) {
    stopped = adaptive && ++steps >= lengths.most;
    return !stopped;
  };
  const bool cut = how.end_time < wanted - 1e-9 * (wanted - start);  // shorter than the scene
  Tried out{.end = how.end_time};
  const auto trajectory = simulate(system, system.initial, how, observer);
  if (!trajectory) {
    out.outcome = of_error(trajectory.error());
    // a failure after the scene's end does not concern the scene (two steps: a run has whole ones)
    if (out.outcome == Outcome::not_solved && !adaptive && lengths.least > 1 &&
        how.end_time > wanted + 2 * how.step) {
      how.end_time = wanted;
      return try_run(system, how, setting, {1, lengths.most});
    }
    out.reason = trajectory.error().message();
    out.energy = out.constraint = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  const Certificate& c = trajectory->certificate;
  const double reached = trajectory->times.back();
  out.outcome = stopped && reached < how.end_time ? Outcome::unfinished : judge(system, *trajectory);
  if (cut && !is_unstable(out.outcome)) out.outcome = Outcome::unfinished;
  out.reason = out.outcome != Outcome::unfinished
                   ? c.reason
                   : fmt::format("stopped at {:.4g} s of {:.4g} s, after {} steps (the most allowed)",
                                 reached, wanted, lengths.most);
  out.steps = c.steps_accepted;
  out.evaluations = c.evaluations;
  out.energy =
      c.energy_turnover > 0 ? c.energy_drift / c.energy_turnover : std::numeric_limits<double>::quiet_NaN();
  out.constraint = largest_residual(c);
  return out;
}

}  // namespace borelli
