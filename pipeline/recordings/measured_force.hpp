// A measured ground reaction over time: what force plates and OpenSim's external loads hold.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace borelli {

/// What the ground does to the body: force at a point, and the free moment about that point. Axes as the
/// file's.
struct MeasuredForce {
  std::string name;
  std::vector<double> times;  ///< s, increasing
  Eigen::Matrix3Xd force;     ///< N, one column per time
  Eigen::Matrix3Xd point;     ///< m, the centre of pressure; NaN where the force is too small to have one
  Eigen::Matrix3Xd moment;    ///< N m, about the point; NaN where the point is
};

}  // namespace borelli
