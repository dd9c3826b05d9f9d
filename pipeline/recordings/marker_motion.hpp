// Measured positions of markers over time: what TRC and C3D files hold.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace borelli {

struct MarkerMotion {
  std::vector<std::string> names;
  std::vector<double> times;  ///< s, increasing; one per frame
  std::vector<Eigen::Matrix3Xd>
      frames;  ///< m, in the file's axes, one column per name; NaN where a marker was not seen
  std::optional<Eigen::Vector3d>
      up;  ///< unit vector away from the ground in the file's axes, if the file gives it
};

}  // namespace borelli
