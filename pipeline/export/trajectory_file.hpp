// Trajectories as HDF5 (all of it, to be read back here or by h5py, MATLAB ...) and as CSV (a table for a
// spreadsheet).
// The HDF5 layout stands as a table in pipeline/README.md.
// CSV: one row per output time; columns time, q, v, a, energies, momenta, multipliers, drives, every solid's
// pose and, where asked for, the reactions of its joint, each with its unit in brackets; lines before the
// header begin with '#' and hold the certificate.
#pragma once

#include <filesystem>
#include <string>

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"

namespace borelli {

/// Writes .h5/.hdf5 or .csv, by the path's ending. `scene` is the text of the scene that was simulated.
Result<void> write_trajectory(const Trajectory& trajectory, const std::string& scene,
                              const std::filesystem::path& path);

struct StoredTrajectory {
  Trajectory trajectory;
  std::string scene;  ///< the scene's TOML text
};

/// Reads an HDF5 trajectory back: every number as it was, orientations to rounding. A file that is damaged,
/// cut short or of another make ends in an error.
Result<StoredTrajectory> read_trajectory(const std::filesystem::path& path);

/// Whether a file is an HDF5 trajectory, by its format attribute.
bool is_trajectory(const std::filesystem::path& path);

}  // namespace borelli
