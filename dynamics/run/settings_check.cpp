#include "dynamics/run/settings_check.hpp"

#include <fmt/format.h>

#include <cmath>

#include "dynamics/system/fastest_change.hpp"
#include "dynamics/system/knots.hpp"

namespace borelli {

Result<void> check_settings(const SimulationSettings& settings, double start) {
  const auto refuse = [](const char* name, double found, const char* expected) {
    return bad_use(fmt::format("simulation, {}", name), fmt::format("is {}; expected {}", found, expected));
  };
  if (!std::isfinite(settings.end_time) || settings.end_time < start)
    return refuse("end_time", settings.end_time, "a time (s) at or after the start");
  if (!std::isfinite(settings.step) || settings.step <= 0)
    return refuse("step", settings.step, "a positive time, s");
  if (!std::isfinite(settings.tolerance) || settings.tolerance <= 0)
    return refuse("tolerance", settings.tolerance, "a positive number");
  if (settings.accuracy != 0 && !(settings.accuracy >= 1e-11 && settings.accuracy <= 0.1))
    return refuse("accuracy", settings.accuracy, "1e-11 to 0.1, or 0 for none");
  if (!(settings.spectral_radius >= 0 && settings.spectral_radius <= 1))
    return refuse("spectral_radius", settings.spectral_radius, "0 to 1");
  if (!std::isfinite(settings.output_interval) || settings.output_interval < 0)
    return refuse("output_interval", settings.output_interval, "a time (s), or 0 for every step");
  if (!std::isfinite(settings.rest_speed) || settings.rest_speed <= 0)
    return refuse("rest_speed", settings.rest_speed, "a positive speed, m/s");
  if (!std::isfinite(settings.baumgarte_alpha) || settings.baumgarte_alpha < 0)
    return refuse("baumgarte_alpha", settings.baumgarte_alpha, "a gain of at least 0, 1/s");
  if (!std::isfinite(settings.baumgarte_beta) || settings.baumgarte_beta < 0)
    return refuse("baumgarte_beta", settings.baumgarte_beta, "a gain of at least 0, 1/s");
  if (!std::isfinite(settings.energy_threshold) || settings.energy_threshold < 0)
    return refuse("energy_threshold", settings.energy_threshold,
                  "a part of the energy turned over, or 0 for the method's own");
  return {};
}

Result<void> check_counts(const System& system, double start, const SimulationSettings& settings,
                          bool adaptive) {
  const auto refuse = [](const char* name, double found, double count, const char* of, double most) {
    return bad_use(fmt::format("simulation, {}", name),
                   fmt::format("is {} s, which makes {:.3g} {} up to the end_time; expected at most {:.0e}",
                               found, count, of, most));
  };
  const double span = settings.end_time - start, interval = settings.output_interval;
  if (interval > 0 && span / interval > most_rows)
    return refuse("output_interval", interval, span / interval, "rows of output", most_rows);
  if (!adaptive) {
    if (const double steps = span / settings.step; steps > most_steps)
      return refuse("step", settings.step, steps, "steps", most_steps);
    else if (interval == 0 && steps > most_rows)
      return refuse("step", settings.step, steps, "rows of output (there is no output_interval)", most_rows);
    return {};
  }
  if (const double knots = Knots(system, system.parameters).count(start, settings.end_time);
      knots > most_steps)
    return bad_use(
        "simulation, end_time",
        fmt::format("{:.3g} pieces of tables lie before it; expected at most {:.0e}", knots, most_steps));
  if (const auto change = fastest_change(system, system.parameters, span, false)) {
    const double steps = span / (longest_step_in_periods * change->period);
    if (steps > most_steps)
      return bad_use(change->name, fmt::format("its {} is {:.3g} s, and steps of an eighth of it make {:.3g} "
                                               "steps up to the end_time; expected at most {:.0e}",
                                               change->wave, change->period, steps, most_steps));
  }
  return {};
}

Result<void> check_time_stepping(const System& system, const std::string& method, bool handles_contacts) {
  if (handles_contacts) return {};
  for (const Constraint& constraint : system.parameters.constraints) {
    const bool refused =
        std::visit([]<class Kind>(const Kind&) { return TimeStepping<Kind>; }, constraint.kind);
    if (refused)
      return bad_use(
          fmt::format("{}constraint '{}'", place_in(system.file, constraint.line), constraint.name),
          fmt::format("contacts of convex shapes need the method moreau; found {}", method));
  }
  return {};
}

}  // namespace borelli
