// Difference between two motions of the same solids: the definition of error in charts.
#pragma once

#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

struct MotionDifference {
  double position = 0;     ///< m, of a solid's gravity centre
  double orientation = 0;  ///< rad, the angle between two orientations
  /// Keeps the larger of each number.
  void widen(const MotionDifference& other);
};

/// Gravity centre of each solid in its own frame, m; the origin if it has no mass. The scene must compile.
std::vector<Eigen::Vector3d> gravity_centres(const Scene& scene);

/// Difference between two poses of one solid with its gravity centre at `centre` in its own frame.
MotionDifference pose_difference(const Pose& a, const Pose& b, const Eigen::Vector3d& centre);

/// The largest difference over all solids; `a` and `b` hold one pose per solid.
MotionDifference motion_difference(const Pose* a, const Pose* b, const std::vector<Eigen::Vector3d>& centres);

}  // namespace borelli
