// Maps a point of a body at rest to the warped body: segments are scaled one by one, skin moves outwards or
// inwards, joints turn.
//
// A point with share s_j of the motion of each joint j moves in these steps:
//   skin     x += lift * fat * n, with n perpendicular to the segment's axis. Bones stay.
//   scale    z = scaled_root(x) + sum over joints j of s_j (scaled_behind(x) - scaled_before(x)).
//            scaled_p stretches part p along and across its axis, about the joint to its parent. That joint
//            moves with the scaled parent.
//   twist    Forearm and hand turn about the forearm's axis, by the share of the way from elbow to wrist.
//   turn     From the farthest joint to the nearest, z turns about the joint's scaled centre by s_j times its
//            rotation vector.
//   whole    The whole body turns.
// If every s_j is 0 or 1, as in bones, the map is affine, and rigid without scaling.
#pragma once

#include <Eigen/Geometry>
#include <array>

#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/suite/body_lattice.hpp"

namespace borelli::suite {

/// Numbers by label as in parts.hpp; angles in rad about the axes of the body at rest (LPS).
struct Motion {
  std::array<double, parts.size()> length{}, girth{};  ///< factors along and across a part's axis
  std::array<double, parts.size()> fat{};              ///< outward motion of skin, mm
  std::array<Eigen::Vector3d, n_joints> turn{};        ///< rotation vectors
  std::array<double, 2> pronation{};                   ///< left, right: about the line from elbow to wrist
  Eigen::Matrix3d whole = Eigen::Matrix3d::Identity();

  Motion();  ///< the body as it is
};

class BodyMap {
 public:
  BodyMap(const Landmarks& rest, const Motion& motion);

  Eigen::Vector3d operator()(const Eigen::Vector3d& rest, const Shares& shares, double lift) const;

  /// The motion of a part's bones alone, as if lift were 0 and all shares 0 or 1.
  Eigen::Vector3d with_part(int label, const Eigen::Vector3d& rest) const;

 private:
  Eigen::Vector3d push(const Eigen::Vector3d& rest, const Shares& shares) const;
  Eigen::Vector3d scaled(std::size_t label, const Eigen::Vector3d& x) const {
    return moved_[label] + stretch_[label] * (x - pivot_[label]);
  }

  std::array<Eigen::Vector3d, parts.size()> pivot_, moved_;  ///< by part: its joint at rest, scaled
  std::array<Eigen::Matrix3d, parts.size()> stretch_;
  struct Axis {
    Eigen::Vector3d point, along;
  };
  std::array<Axis, parts.size()> axis_;
  std::array<std::size_t, n_joints> before_{}, behind_{};
  std::array<Eigen::AngleAxisd, n_joints> turn_;
  std::array<Eigen::Matrix3d, n_joints> full_;
  std::array<Eigen::Vector3d, 2> wrist_rest_;
  Motion motion_;
};

/// The shares of a part's bones: 1 for joints between the root and it, else 0.
Shares shares_of_part(int label);

}  // namespace borelli::suite
