// Where two convex shapes touch, or are nearest.
#pragma once

#include <array>

#include "dynamics/scene/convex.hpp"

namespace borelli {

/// One contact point on the surface of a shape; world axes, m.
struct ConvexPoint {
  bool used = false;
  bool rolls =
      false;  ///< moves over its shape with the normal (see roundness); else it is fixed in the shape
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  double gap = 0;
};

/// The contacts of two convex shapes. The separation along a unit vector n is the least n . (p_a - p_b) over
/// all points of both: the signed distance is its maximum over n, here at `normal`.
struct ConvexTouch {
  enum class Flat { neither, a, b };
  Flat flat = Flat::neither;  ///< the shape that touches with a flat face; the normal is fixed in it
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< from b to a
  double gap = 0;  ///< least distance of the shapes, m, within 1e-9 of their size; negative: overlap
  int count = 1;   ///< number of slots: 1, 2 or 8
  std::array<ConvexPoint, 8> points;  ///< on the shape without the flat face; on a if neither has one
  /// Change of the farthest point of a (b) per change of its outward normal, m.
  Eigen::Matrix3d roundness_a = Eigen::Matrix3d::Zero(), roundness_b = Eigen::Matrix3d::Zero();
  /// Direction of the straight line on which a (b) touches; zero: none.
  Eigen::Vector3d line_a = Eigen::Vector3d::Zero(), line_b = Eigen::Vector3d::Zero();
};

/// `X_a`, `X_b`: poses of the shapes' own frames in the world. `count`: 1, 2 or 8 contacts. Far shapes get no
/// point, and the distance of their bounding spheres as gap.
ConvexTouch touch_of(const Convex& a, const Pose& X_a, const Convex& b, const Pose& X_b, int count);

/// The same for a half space (b) below the plane through `on` with a unit normal; `across`: a unit vector in
/// the plane, fixed in its solid.
ConvexTouch touch_of_plane(const Convex& a, const Pose& X_a, const Eigen::Vector3d& on,
                           const Eigen::Vector3d& normal, const Eigen::Vector3d& across, int count);

}  // namespace borelli
