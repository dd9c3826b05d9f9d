// Poses of a skin's bones, and the skin in these poses.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "pipeline/export/skin.hpp"

namespace borelli {

/// A rotation as a twist about `axis` followed by a swing about a line normal to it: R = R_swing R_twist
/// (Dobrowolski (2015) "Swing-twist decomposition in Clifford algebra", arXiv:1506.05481).
struct SwingTwist {
  Eigen::Vector3d swing_axis{1, 0, 0};  ///< unit, normal to `axis`
  double swing = 0;                     ///< 0 to pi
  double twist = 0;  ///< -pi to pi, about `axis`; 0 at a swing of pi, where it is undefined
};
SwingTwist swing_twist(const Eigen::Matrix3d& R, const Eigen::Vector3d& axis);

/// X_WB of each bone when parts have the poses X_WS (by name). A part without a pose moves with its parent; a
/// root without one stays. A joint's helper takes shares of the part's displacement from the scan's pose
/// relative to its parent's: a share of the swing, one of the twist, and of the joint centre's translation
/// the same share as of the swing.
std::vector<Pose> bone_poses(const Skin& skin, const ScanPoses& X_WS);

/// X_WB in the scan's pose: a helper's frame has its origin at the joint and the world's axes.
std::vector<Pose> rest_poses(const Skin& skin);

/// The points p_WP of the skin, by linear blending, as a glTF viewer computes them.
std::vector<Eigen::Vector3d> deformed(const Skin& skin, const ScanPoses& X_WS);

}  // namespace borelli
