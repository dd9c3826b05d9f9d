// Many motions of one System, eight at a time in the lanes of a batch (batch.hpp), over all cores: starts,
// inertial elements or efforts that vary. The eight share their steps, as short as the one needs that asks
// for most.
//
// For smooth scenes, as batches are. A motion that meets a limit spring's bound, or whose equations or steps
// fail where the others' do not, leaves its batch and is made anew by simulate(), with all that this does for
// events, verdict and reasons.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// One motion of an ensemble.
struct Member {
  State start;                      ///< of one time for all members, s
  std::vector<Inertial> inertials;  ///< per body of the System, in the body's frame; empty: its own
  /// Generalized efforts beside the scene's, the same all along, and their work counts: per velocity of the
  /// System (nv), N or N m, of a ball in its own axes. Empty: none.
  Eigen::VectorXd efforts = {};
};

/// How a motion ended. In a batch it is trusted if the energy balance of each independent group holds, as
/// simulate() judges it, and if fixed steps follow what the scene prescribes in time.
struct Ending {
  State state;  ///< at settings.end_time; empty where the motion did not come to it
  bool trusted = false;
  std::string reason;       ///< why not; empty when trusted
  double energy_drift = 0;  ///< of the worst group, in parts of what it turned over
  long steps = 0;           ///< accepted ones
  bool alone = false;       ///< it was made by simulate()
};

/// The motions from their starts to settings.end_time, in the order of `members`. `threads`: 0: all cores.
/// Methods: the explicit ones (euler, rk2, rk4, rk4_adaptive, dopri5, dop853, gbs and its fixed orders),
/// gauss16, semi_implicit_euler and verlet; settings.output_interval and accuracy are not for ensembles.
/// Fails where no motion could be made: a scene that batches refuse, settings that make no sense, starts and
/// efforts that do not fit, members' bodies that cannot exist (check_physical).
/// `progress` is told how many motions are made, at every step, by one thread at a time. Where it returns
/// false, the motions that are not made yet have no state, and say so; they may be made by another call.
Result<std::vector<Ending>> simulate_ensemble(const System& system, const std::vector<Member>& members,
                                              const SimulationSettings& settings, int threads = 0,
                                              const std::function<bool(std::size_t made)>& progress = {});

}  // namespace borelli
