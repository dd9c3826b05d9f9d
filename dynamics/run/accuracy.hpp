// Runs to a given accuracy: chooses method and tolerance, and estimates the error by comparing two runs.
//
// Two runs at different tolerances differ by about the error of the coarser one, and errors are about
// proportional to tolerances. A run is compared with a run at a tolerance 1e5 times coarser; its own error is
// estimated as that much smaller a fraction of their difference. If the estimate is above the accuracy, a
// finer run follows. If a run meets stops or contacts, errors depend less regularly on tolerances: the
// estimate then uses the square root of the ratio, and if two runs more than 1000 times apart do not suffice,
// the next tolerance is close to the last. With `verify`, the tolerances differ by a factor of ten and the
// whole difference counts as the error. The first run is disturbed a little, at its start and on its way, so
// that two runs cannot agree on a feature that both are too coarse to resolve. Where functions of time limit
// nearly all steps, whatever the tolerance, another run with shorter steps is compared.
//
// Accuracy is relative to each component's scale (System::velocity_scale: 1 rad, or the length of what a
// coordinate carries; for velocities the same per second plus their own size). It is judged at times that
// both runs sample with dense output.
#pragma once

#include <functional>

#include "dynamics/run/run_limits.hpp"
#include "dynamics/run/samples.hpp"
#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"

namespace borelli {

/// One run with the given settings and limits; fills in the samples.
using RunOnce =
    std::function<Result<Trajectory>(const SimulationSettings&, const RunLimits&, Samples& samples)>;

/// The largest difference between two runs of one system, relative to the component's scale.
struct Difference {
  double size = 0;
  double time = 0;      ///< s
  int coordinate = -1;  ///< index in System::coordinates; -1: none
};
/// Over the sampling times that both runs reached.
Difference largest_difference(const System& system, const Samples& a, const Samples& b);

/// Runs from time `start` (s) to settings.accuracy (> 0). Starts with dop853. If that finds the scene stiff,
/// cvode takes over, or arkode if constraints are projected. The implicit method may spend the evaluations
/// that the abandoned run would have needed at its step size. If that does not suffice, the scene was not
/// stiff after all (a passage through a singular position looks stiff), and the explicit method may spend
/// five times the evaluations spent so far. The two alternate until one reaches the end. The certificate
/// states the choice and the reason; it does not trust a run whose accuracy could not be shown (a chaotic
/// motion over a long time). `stopped` tells whether the user has stopped the last run. Fails as simulate()
/// does.
Result<Trajectory> run_to_accuracy(const System& system, double start, const SimulationSettings& settings,
                                   const RunOnce& run, const std::function<bool()>& stopped);

}  // namespace borelli
