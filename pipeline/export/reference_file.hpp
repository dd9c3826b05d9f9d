// A motion that a user knows better than any run (a closed form, a published solution, another program's),
// for charts of error.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "error/error.hpp"

namespace borelli {

struct GivenReference {
  std::string name;           ///< the file's
  double error = 1e-12;       ///< what it is off by, over the scene's length, and in rad
  std::vector<double> times;  ///< s, rising
  std::vector<Pose> poses;    ///< X_WS: [time * solids + solid]
};

/// Reads an HDF5 trajectory, or CSV with a line of names, among them "time [s]" and, of each of `solids`,
/// "position NAME.x [m]" ... and "orientation NAME.w [1]", .x, .y, .z (a quaternion, made unit): as
/// `simulate` writes both. Other columns, and lines that begin with '#', count for nothing. Errors name what
/// is missing, or the line that is wrong.
Result<GivenReference> read_reference(const std::filesystem::path& path,
                                      const std::vector<std::string>& solids);

}  // namespace borelli
