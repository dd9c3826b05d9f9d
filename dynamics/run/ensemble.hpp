// Simulates many motions of one System on all cores, eight at a time in the lanes of a batch (batch.hpp).
// Initial states, inertial elements or efforts may vary. The eight motions share their steps; the most
// demanding one sets the step.
//
// For smooth scenes, as batches are. A motion leaves its batch if it reaches a limit spring's bound, or if
// its equations or steps fail. simulate() then makes it again, with events, verdict and reasons.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// One motion of an ensemble.
struct Member {
  State start;                      ///< same time (s) for all members
  std::vector<Inertial> inertials;  ///< per body of the System, in body frame; empty: the System's own
  /// Constant generalised forces added to the scene's; their work counts. Per velocity of the System (nv), N
  /// or N m; for a ball in its own axes. Empty: none.
  Eigen::VectorXd efforts = {};
};

/// The end of a motion. A batch trusts it if the energy balance of each independent group holds, as judged in
/// simulate(), and if fixed steps resolve the scene's functions of time.
struct Ending {
  State state;  ///< at settings.end_time; empty if the motion did not reach it
  bool trusted = false;
  std::string reason;       ///< reason for distrust; empty when trusted
  double energy_drift = 0;  ///< of the worst group, relative to its turnover
  long steps = 0;           ///< accepted steps
  bool alone = false;       ///< made by simulate()
};

/// Simulates all motions from their initial states to settings.end_time, in the order of `members`.
/// `threads`: 0: all cores. Methods: the explicit ones (euler, rk2, rk4, rk4_adaptive, dopri5, dop853, gbs
/// and its fixed orders), gauss16, semi_implicit_euler and verlet. settings.output_interval is ignored,
/// settings.accuracy refused.
/// Fails for a scene that batches refuse, invalid settings, initial states or efforts of the wrong size, or
/// impossible inertial elements (check_physical).
/// `progress` receives the number of finished motions, at every step, from one thread at a time. If it
/// returns false, the unfinished motions have no state and say so in `reason`; another call may make them.
Result<std::vector<Ending>> simulate_ensemble(const System& system, const std::vector<Member>& members,
                                              const SimulationSettings& settings, int threads = 0,
                                              const std::function<bool(std::size_t made)>& progress = {});

}  // namespace borelli
