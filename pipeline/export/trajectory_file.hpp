// Writes trajectories as HDF5 (complete; read back here or by h5py, MATLAB ...) and as CSV (a table for
// spreadsheets). docs/file_formats.md gives the HDF5 layout. CSV: one row per output time; columns time, q,
// v, a, energies, momenta, multipliers, drives, every solid's pose and, if requested, the reactions of its
// joint, each with its unit in brackets. Lines before the header begin with '#' and hold the certificate.
#pragma once

#include <filesystem>
#include <string>

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"

namespace borelli {

/// Writes .h5/.hdf5 or .csv, by the path's extension. `scene`: text of the simulated scene.
Result<void> write_trajectory(const Trajectory& trajectory, const std::string& scene,
                              const std::filesystem::path& path);

struct StoredTrajectory {
  Trajectory trajectory;
  std::string scene;  ///< the scene's TOML text
};

/// Reads an HDF5 trajectory: every number exactly, orientations to rounding. Errors: a damaged, truncated or
/// foreign file.
Result<StoredTrajectory> read_trajectory(const std::filesystem::path& path);

/// Whether a file is an HDF5 trajectory, by its format attribute.
bool is_trajectory(const std::filesystem::path& path);

}  // namespace borelli
