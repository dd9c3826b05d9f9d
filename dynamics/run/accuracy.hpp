// A run to an asked accuracy: method and tolerance are chosen here, and the error is estimated by running
// twice.
//
// Two runs at unlike tolerances differ by about the error of the coarser one, and errors are about in
// proportion to the tolerances. So a run is compared with one before it, a hundred thousand times coarser,
// and its own error is estimated as so much smaller a part of the difference; where that is above the
// accuracy, a finer run follows. Where a run meets stops or contacts, errors go with tolerances less evenly:
// then they count by the square root of these, and where two more than a thousand times apart do not do, the
// next is near. To verify, the two stand but a factor of ten apart, and all that they differ by counts. The
// first run is put off a little, at its start and on its way, so that two runs do not agree on what both are
// too coarse to see.
// Accuracy counts on each component's scale (System::velocity_scale: 1 rad, or the length of what a
// coordinate carries; velocities per second, and of their own size), at times that both runs look at, from
// the methods' dense output.
#pragma once

#include <functional>

#include "dynamics/run/simulate.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// The states of a run at times that other runs are looked at, too.
struct Samples {
  std::vector<double> times;          ///< s, rising, after the start
  std::vector<Eigen::VectorXd> q, v;  ///< as many as the run has come to
  /// The least and the largest of each number of q and v, at the start and after all steps, too: what moves
  /// in step with the times moves all the same.
  Eigen::VectorXd q_low, q_high, v_low, v_high;
  long evaluations = 0;  ///< that the run took, also where it failed

  void cover(const State& state) {
    if (q_low.size() == 0) {
      q_low = q_high = state.q;
      v_low = v_high = state.v;
    }
    q_low = q_low.cwiseMin(state.q), q_high = q_high.cwiseMax(state.q);
    v_low = v_low.cwiseMin(state.v), v_high = v_high.cwiseMax(state.v);
  }
};

/// One run with those settings; fills in the samples.
using RunOnce =
    std::function<Result<Trajectory>(const SimulationSettings&, const RunLimits&, Samples& samples)>;

/// The largest difference of two runs of one system, as above.
struct Difference {
  double size = 0;
  double time = 0;      ///< s
  int coordinate = -1;  ///< in System::coordinates; -1: there is none
};
Difference largest_difference(const System& system, const Samples& a, const Samples& b);

/// Runs from time `start` (s) to settings.accuracy (> 0): by dop853; where it finds
/// the scene stiff by cvode, or by arkode where constraints are projected. These may spend what the run that
/// was left would have taken at its steps; where that does not do, the stiffness was none (a passage through
/// a singular position looks like it) and the explicit method may spend five times what has been spent, and
/// so on in turn until one comes through. The certificate says what was chosen and why, and distrusts a run
/// whose accuracy could not be shown (a chaotic motion over a long time). `stopped` tells whether the user
/// has ended the last run.
Result<Trajectory> run_to_accuracy(const System& system, double start, const SimulationSettings& settings,
                                   const RunOnce& run, const std::function<bool()>& stopped);

}  // namespace borelli
