// Integrates a system through time: a trajectory with its certificate, or the reason why there is none.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "dynamics/run/event.hpp"

namespace borelli {

/// Where a run may end before its time, and how it may begin.
struct RunLimits {
  /// it turns out stiff (Certificate::stiff_from tells), and at its present steps what is left takes half as
  /// many again as were tried so far
  bool leave_if_stiff = false;
  double evaluations = std::numeric_limits<double>::infinity();  ///< it takes more than so many
  /// where the method has a first step of its own (Integrator::first_step), it is that, not settings.step
  bool own_first_step = false;
  /// its velocities are put off by that part of their scales (disturbance.hpp) at the start, and, where work
  /// is done on the scene and the method has no history, now and then on the way
  double disturbance = 0;
};

struct Observer {
  /// Called after each accepted step with the time reached (s); false stops the run, whose trajectory so far
  /// is then returned, untrusted.
  std::function<bool(double t)> progress;
  /// Called as each run ends, also one that fails, with the evaluations that it took.
  std::function<void(long evaluations)> ended;
  /// The user's own events, beside those that the scene has; they must outlive the run.
  std::vector<EventSource*> events;
  /// Where it is set: is given all that a later run needs to go on exactly from the step just made, whenever
  /// keep_due says so and when `progress` stops the run. With a user's own events, the method `cvode` or an
  /// accuracy (several runs) there is no such thing, and simulate() fails at once.
  std::function<void(const std::string& checkpoint)> keep;
  std::function<bool()> keep_due;
  /// What `keep` was given by a run of the same system, state and settings: the run goes on from there, and
  /// its trajectory and certificate are, bit for bit, those of one that was never broken off. Empty: from the
  /// start.
  std::string checkpoint;
  /// Where it is set: is given the trajectory so far, whose certificate trusts nothing, whenever rows_due
  /// says so.
  std::function<void(const Trajectory& so_far)> rows = {};
  std::function<bool()> rows_due = {};
  /// Of a run by a named method: where it takes more evaluations, or turns out stiff
  /// (Certificate::stiff_from), the trajectory so far is returned, too. Of one to an accuracy `evaluations`
  /// are of all its runs together; it fails where it takes more.
  RunLimits limits = {};
};

/// Runs from `state` (assembled on the constraints first) to settings.end_time. The trajectory holds the
/// start, every multiple of the output interval, and the end; with interval 0, every accepted step. Rows
/// between steps come from the method's dense output where that is as good as its steps; else steps end on
/// output times, fixed ones shortened so that a whole number of them fits.
///
/// Fails, with the time reached, where the motion cannot be continued: contradictory constraints, a singular
/// mass matrix, numbers that are not finite or grow beyond bounds, a step that underflows. A run that comes
/// through but is not to be relied upon says so in its certificate.
Result<Trajectory> simulate(const System& system, const State& state, const SimulationSettings& settings,
                            const Observer& observer = {});

/// With the initial state and the settings of the scene.
Result<Trajectory> simulate(const System& system);

}  // namespace borelli
