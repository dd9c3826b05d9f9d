// Reads a reference motion that the user supplies (a closed form, a published solution, another program's
// result), for charts of error.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "error/error.hpp"

namespace borelli {

struct GivenReference {
  std::string name;           ///< of the file
  double error = 1e-12;       ///< its own error: over the scene's length, and in rad
  std::vector<double> times;  ///< s, rising
  std::vector<Pose> poses;    ///< X_WS: [time * solids + solid]
};

/// Reads an HDF5 trajectory or a CSV file, both as `simulate` writes them. The CSV has a line of names with
/// "time [s]" and, for each of `solids`, "position NAME.x [m]" ... and "orientation NAME.w [1]", .x, .y, .z
/// (a quaternion, normalised on reading). Other columns and lines that begin with '#' are ignored. Errors
/// name the missing column or the wrong line.
Result<GivenReference> read_reference(const std::filesystem::path& path,
                                      const std::vector<std::string>& solids);

}  // namespace borelli
