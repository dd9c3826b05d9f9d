// A recorded motion as a trajectory, to be shown and exported like a simulated one.
#pragma once

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"

namespace borelli {

/// Times, positions, velocities and accelerations of the smooth motion, with the poses, momenta and energies that
/// follow from them. Nothing was integrated: the certificate's method is "captured motion", and `work` is the
/// change of energy, which the joints and the ground account for. Errors: as evaluate.
Result<Trajectory> recorded_trajectory(const System& system, const RecordedEfforts& motion);

}  // namespace borelli
