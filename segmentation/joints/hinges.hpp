// Joint ends that are cylinders about the joint's axis: condyles of the knee, trochlea of the elbow, dome of
// the talus.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "segmentation/body/bone_edges.hpp"

namespace borelli {

struct Hinge {
  Eigen::Vector3d point =
      Eigen::Vector3d::Zero();  ///< on the axis, nearest to where it was looked for; mm, LPS
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit
  double radius = 0;                                ///< mm
  double score = 0;      ///< share of the rays about the axis whose edge agrees, 0 to 1
  double deviation = 0;  ///< rms distance of the agreeing edges from the cylinder, mm
  double other = 0;      ///< to the farthest other place that about as many edges agree on, mm (`farthest`)
};

/// The cylinder that most bone edges agree on: rays leave points of the axis, up to `reach` mm to both sides,
/// square to it; edges lie within `least` to `most` mm. Its place is looked for within `search` mm of `near`;
/// its axis may turn some 15 degrees from `axis`. Shafts and the other bone's end are round as well, so
/// several places are tried: the one that most rays choose counts, unless far more edges agree on another's
/// cylinder to the side that the joint's surface faces (unit `facing`; to the other side a shaft goes on) and
/// it lies near. With `farthest` it is the one that lies farthest to that side of those that about as many
/// agree on, wherever it lies: on large voxels the shaft agrees as well, and where a bone ends is told by it
/// alone. With a `facing` of zero no other place is tried. Nothing where less than a quarter of the
/// rays agree, or where the scan's slices are too thick to show such a cylinder (over 0.9 of `least`).
std::optional<Hinge> fit_hinge(const CloseUp& view, const Eigen::Vector3d& near, const Eigen::Vector3d& axis,
                               const Eigen::Vector3d& facing, double reach, double least, double most,
                               double search, bool farthest = false);

}  // namespace borelli
