// A run to an asked accuracy: method and tolerance are chosen here, and the error is estimated by running
// twice.
//
// The first tolerance is a tenth of the accuracy, each next at most a tenth of that before. What two runs
// differ by estimates the error of the coarser one (the finer's is about a tenth of it; more where rounding
// allows no tolerance so much smaller, and the estimate grows with that); once it is within the accuracy the
// finer run is returned. Accuracy counts on each component's scale (System::velocity_scale:
// 1 rad, or the length of what a coordinate carries; velocities per second, and of their own size), at times
// that both runs look at, from the methods' dense output.
#pragma once

#include <functional>
#include <limits>

#include "dynamics/system.hpp"

namespace borelli {

/// The states of a run at times that other runs are looked at, too.
struct Samples {
  std::vector<double> times;          ///< s, rising, after the start
  std::vector<Eigen::VectorXd> q, v;  ///< as many as the run has come to
};

/// What ends a run before its time.
struct RunLimits {
  bool leave_if_stiff = false;  ///< it turns out stiff (Certificate::stiff_from tells)
  double evaluations = std::numeric_limits<double>::infinity();  ///< it takes more than so many
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

/// Runs from time `start` (s) to settings.accuracy (> 0): by dop853, or dopri5 from 1e-4 up; where these find
/// the scene stiff by cvode, or by arkode where constraints are projected. These may spend five times what
/// has been spent; where that does not do, the stiffness was none (a passage through a singular position
/// looks like it) and the explicit method may spend five times as much again, and so on in turn until one
/// comes through. The certificate says what was chosen and why, and distrusts a run whose accuracy could not
/// be shown (a chaotic motion over a long time). Without settings.verify the first run that comes through is
/// the answer, and its error is not known. `stopped` tells whether the user has ended the last run.
Result<Trajectory> run_to_accuracy(const System& system, double start, const SimulationSettings& settings,
                                   const RunOnce& run, const std::function<bool()>& stopped);

}  // namespace borelli
