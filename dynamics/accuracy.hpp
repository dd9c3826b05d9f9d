// A run to an asked accuracy: method and tolerance are chosen here, and the error is estimated by running
// twice.
//
// The first tolerance is a tenth of the accuracy, each next at most a tenth of that before. What two runs
// differ by estimates the error of the coarser one (the finer's is about a tenth of it; more where rounding
// allows no tolerance so much smaller, and the estimate grows with that); once it is within the accuracy the
// finer run is returned. Accuracy counts on each component's scale (System::velocity_scale:
// 1 rad, or the length of what a coordinate carries; velocities per second, and of their own size), at all
// rows of an output interval, or at the end where every step is a row.
#pragma once

#include <functional>

#include "dynamics/system.hpp"

namespace borelli {

/// One run with those settings; ended early where it turns out stiff, if asked (Certificate::stiff_from
/// tells).
using RunOnce = std::function<Result<Trajectory>(const SimulationSettings&, bool leave_if_stiff)>;

/// The largest difference of two runs of one system, as above; their rows must be at the same times but for
/// output_interval = 0.
double largest_difference(const System& system, const Trajectory& a, const Trajectory& b);

/// Runs to settings.accuracy (> 0): by dop853, or dopri5 from 1e-4 up; where these find the scene stiff by
/// cvode, or by arkode where constraints are projected. The certificate says what was chosen and why, and
/// distrusts a run whose accuracy could not be shown (a chaotic motion over a
/// long time). `stopped` tells whether the user has ended the last run.
Result<Trajectory> run_to_accuracy(const System& system, const SimulationSettings& settings,
                                   const RunOnce& run, const std::function<bool()>& stopped);

}  // namespace borelli
