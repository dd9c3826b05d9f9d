// How far two motions of the same solids are apart: what error means in charts.
#pragma once

#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

struct MotionDifference {
  double position = 0;     ///< m, of a solid's gravity centre
  double orientation = 0;  ///< rad, the angle between two orientations
  /// Takes what is larger.
  void widen(const MotionDifference& other);
};

/// The gravity centre of each solid in its own frame, m; the origin where it has no mass. Of a scene that
/// compiles.
std::vector<Eigen::Vector3d> gravity_centres(const Scene& scene);

/// By how much two poses of one solid differ, whose gravity centre is at `centre` in its frame.
MotionDifference pose_difference(const Pose& a, const Pose& b, const Eigen::Vector3d& centre);

/// The largest over all solids, of which a and b hold a pose each.
MotionDifference motion_difference(const Pose* a, const Pose* b, const std::vector<Eigen::Vector3d>& centres);

}  // namespace borelli
