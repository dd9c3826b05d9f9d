#include "dynamics/run/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/run/accuracy.hpp"
#include "dynamics/run/disturbance.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/run/settings_check.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

namespace {

/// Requests memory for everything but the output rows, which Recorder::admit() covers.
Result<void> admit_run(const System& system, const SimulationSettings& settings,
                       const Integrator& integrator) {
  // For steps, for states between them, and for contact events.
  const int workspaces = system.rows == 0                                           ? 1
                         : system.contacts.empty() || integrator.handles_contacts() ? 2
                                                                                    : 3;
  if (auto fits = admit_workspaces(system, settings.equations, workspaces, false); !fits) return fits;
  return admit_large(system, integrator.bytes(2 * system.nv + 4 + system.groups), [&] {
    return fmt::format("the method {} for {} coordinates", settings.method, system.nv);
  });
}

/// One run with the named method.
Result<Trajectory> simulate_once(const System& system, const State& state, const SimulationSettings& settings,
                                 const Observer& observer, const RunLimits& limits = {},
                                 Samples* samples = nullptr) {
  auto integrator = make_integrator(settings.method, settings.tolerance, settings.spectral_radius);
  if (!integrator) return tl::unexpected(integrator.error());
  if (const char* objection = (*integrator)->objection(system, settings.constraints))
    return bad_use(fmt::format("method '{}'", settings.method), objection);
  if ((*integrator)->handles_contacts() && !system.contacts.empty() && !observer.events.empty())
    return bad_use(
        fmt::format("method '{}'", settings.method),
        "resolves contacts within its steps, and a user's own event would cut a step; choose another method");
  if (auto ok = check_time_stepping(system, settings.method, (*integrator)->handles_contacts()); !ok)
    return tl::unexpected(ok.error());
  if (auto ok = check_counts(system, state.t, settings, (*integrator)->adaptive()); !ok)
    return tl::unexpected(ok.error());
  if (observer.keep || !observer.checkpoint.empty()) {
    if (!observer.events.empty())
      return bad_use("checkpoint",
                     "cannot store a user's own events; run without a checkpoint, or without these events");
    if (Keeper trial; !(*integrator)->keep(trial))
      return bad_use(fmt::format("method '{}'", settings.method),
                     "depends on a history that no checkpoint can store; run without a checkpoint, or choose "
                     "another method");
  }
  if (auto fits = admit_run(system, settings, **integrator); !fits) return tl::unexpected(fits.error());
  return at_border(system, [&] {
    std::optional<System> own;  // its springs act, within a step, as at the step's start
    if (has_spring_events(system.parameters)) own = system;
    Run run(own ? *own : system, own ? &own->parameters : nullptr, state, settings, observer, **integrator,
            limits, samples);
    auto out = run.run();
    if (observer.ended) observer.ended(run.evaluations());
    return out;
  });
}

}  // namespace

Result<Trajectory> simulate(const System& system, const State& state, const SimulationSettings& settings,
                            const Observer& observer) {
  if (auto ok = check_state(system, state); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_settings(settings, state.t); !ok) return tl::unexpected(ok.error());
  if (settings.accuracy == 0) return simulate_once(system, state, settings, observer, observer.limits);
  if (!observer.events.empty())
    return bad_use(
        "simulation, accuracy",
        "takes several runs, and a user's own events may change from one to the next; name a method and a "
        "tolerance instead");
  if (observer.keep || !observer.checkpoint.empty())
    return bad_use(
        "simulation, accuracy",
        "needs several runs, which a checkpoint cannot store; name a method and a tolerance instead");
  bool stopped = false;
  Observer watched = observer;
  if (observer.progress)
    watched.progress = [&](double t) {
      stopped = !observer.progress(t);
      return !stopped;
    };
  const double most = observer.limits.evaluations;
  double spent = 0;
  long of_run = 0;
  watched.ended = [&](long evaluations) {
    of_run = evaluations;
    if (observer.ended) observer.ended(evaluations);
  };
  return run_to_accuracy(
      system, state.t, settings,
      [&](const SimulationSettings& chosen, RunLimits limits, Samples& samples) -> Result<Trajectory> {
        limits.evaluations = std::min(limits.evaluations, most - spent);
        const State from = limits.disturbance > 0 ? disturbed(system, state, limits.disturbance) : state;
        of_run = 0;
        auto made = simulate_once(system, from, chosen, watched, limits, &samples);
        samples.evaluations = of_run;
        spent += double(of_run);
        if (!(spent > most)) return made;
        stopped = true;
        return failure(system.scene, fmt::format("needs more than {:.2g} evaluations, the most allowed, for "
                                                 "an accuracy of {:.3g}; give a lower accuracy",
                                                 most, settings.accuracy));
      },
      [&] { return stopped; });
}

Result<Trajectory> simulate(const System& system) {
  return simulate(system, system.initial, system.settings);
}

}  // namespace borelli
