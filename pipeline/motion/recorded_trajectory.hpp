// Converts a recorded motion to a trajectory, so that viewers and exporters treat it like a simulated one.
#pragma once

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"

namespace borelli {

/// Times, positions and poses of all solids; the other members stay empty. `positions`: nq wide.
Trajectory posed_trajectory(const System& system, const RecordedPositions& positions);

/// Takes times, positions, velocities and accelerations from `motion` and computes poses, momenta and
/// energies. `work` is the change of energy since the start, done by joints and ground. Nothing is
/// integrated, so the certificate holds no checks; its method is `captured_method`. Errors: as evaluate.
Result<Trajectory> recorded_trajectory(const System& system, const RecordedEfforts& motion);

}  // namespace borelli
