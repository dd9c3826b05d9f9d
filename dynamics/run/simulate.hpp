// Integrates a system in time: returns a trajectory with its certificate, or the reason for failure.
#pragma once

#include <functional>
#include <string>

#include "dynamics/run/event.hpp"
#include "dynamics/run/run_limits.hpp"

namespace borelli {

struct Observer {
  /// Called after each accepted step with the time reached (s). Returning false stops the run; its trajectory
  /// so far is returned, untrusted.
  std::function<bool(double t)> progress;
  /// Called at the end of each run, also a failed one, with its number of evaluations.
  std::function<void(long evaluations)> ended;
  /// The user's events, in addition to the scene's; they must outlive the run.
  std::vector<EventSource*> events;
  /// Optional. Receives a checkpoint from which a later run continues exactly: whenever keep_due returns
  /// true, and when `progress` stops the run. simulate() fails at once with a user's events, a SUNDIALS
  /// method or an accuracy (several runs), because checkpoints do not support these.
  std::function<void(const std::string& checkpoint)> keep;
  std::function<bool()> keep_due;
  /// A checkpoint from a run of the same system, state and settings; the run continues from there. Its
  /// trajectory and certificate equal, bit for bit, those of an uninterrupted run. Empty: start from the
  /// beginning.
  std::string checkpoint;
  /// Optional. Receives the trajectory so far, with an untrusted certificate, whenever rows_due returns true.
  std::function<void(const Trajectory& so_far)> rows = {};
  std::function<bool()> rows_due = {};
  /// For a run by a named method: the trajectory so far is returned if the run reaches a limit. For a run to
  /// an accuracy, `evaluations` limits all its runs together, and exceeding it is an error.
  RunLimits limits = {};
};

/// Simulates from `state` (first assembled on the constraints) to settings.end_time. The trajectory holds the
/// start, every multiple of the output interval, and the end; with interval 0, every accepted step. Rows
/// between steps come from dense output if it is as accurate as the steps. Otherwise steps end on output
/// times, and fixed steps are shortened so that a whole number of them fits.
///
/// Fails, with the time reached, if the motion cannot be continued: contradictory constraints, a singular
/// mass matrix, numbers that are not finite or grow beyond bounds, a step that underflows. If a run finishes
/// but cannot be trusted, its certificate says so.
Result<Trajectory> simulate(const System& system, const State& state, const SimulationSettings& settings,
                            const Observer& observer = {});

/// Uses the scene's initial state and settings.
Result<Trajectory> simulate(const System& system);

}  // namespace borelli
