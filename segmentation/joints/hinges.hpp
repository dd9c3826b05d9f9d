// Joint surfaces that are cylinders about the joint's axis: femoral condyles, trochlea of the humerus, talar
// dome.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "segmentation/body/bone_edges.hpp"

namespace borelli {

struct Hinge {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< on the axis, nearest to the initial guess; mm, LPS
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit
  double radius = 0;                                ///< mm
  double score = 0;      ///< fraction of the rays from the axis that meet an edge on the cylinder, 0 to 1
  double deviation = 0;  ///< rms distance of those edges from the cylinder, mm
  double other = 0;      ///< distance to the farthest cylinder of similar score, mm (`farthest` only)
};

/// Fits the cylinder that most bone edges agree on. Rays leave points of the axis, up to `reach` mm to both
/// sides of its point, perpendicular to it. Edges count within `least` to `most` mm.
///
/// The point is searched within `search` mm of `near` (mm, LPS); the axis may turn about 15 degrees from
/// `axis`. Shafts and the end of the other bone are round too, so several start points are tried. The start
/// with most agreeing rays wins, unless another is clearly better on the side that the joint's surface faces
/// (unit `facing`; the shaft lies on the other side) and lies near.
///
/// `farthest`: of the cylinders with similar scores take the one farthest along `facing`. On large voxels the
/// shaft fits as well, and only the end of the bone distinguishes the joint. With `facing` zero only the best
/// start is tried.
///
/// Empty if less than a quarter of the rays agree, or if the largest voxel spacing exceeds 0.9 `least`.
std::optional<Hinge> fit_hinge(const CloseUp& view, const Eigen::Vector3d& near, const Eigen::Vector3d& axis,
                               const Eigen::Vector3d& facing, double reach, double least, double most,
                               double search, bool farthest = false);

}  // namespace borelli
