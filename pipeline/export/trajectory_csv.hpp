// Trajectories as text: one row per output time.
#pragma once

#include <filesystem>
#include <vector>

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"

namespace borelli {

/// Unit quaternions w, x, y, z of all poses, one time after the other; the sign is the one nearer to the same
/// solid's previous quaternion.
std::vector<double> orientations(const Trajectory& trajectory);

/// Writes a trajectory as CSV: the columns' names with their units, then one row per output time, each number
/// in full. The last column repeats the certificate's verdict, 1 or 0; it is empty for recorded motions.
Result<void> write_trajectory_csv(const Trajectory& trajectory, const std::filesystem::path& path);

}  // namespace borelli
