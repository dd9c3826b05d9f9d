// The axes of a ball joint of the body, about which its published ranges count, and the ranges about them.
#pragma once

#include <array>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/scene/switch.hpp"
#include "segmentation/volume/warning.hpp"

namespace borelli {

/// What a joint does about one of its axes, and its published range.
struct JointAxis {
  std::string motion;  ///< as in data/joint_ranges.csv, e.g. "adduction"; empty: no range is published
  Range range;         ///< rad; where none is published, the whole turn, -pi to pi
};

struct JointAxes {
  /// R_FA, in anatomical axes F (X forwards, Y up, Z to the right) of parent and part, which are parallel in
  /// the neutral position. A's columns are the axes about which the three motions are positive: of a limb
  /// flexion (ankle: dorsiflexion), adduction (wrist: ulnar deviation, ankle: inversion) and internal
  /// rotation (wrist: pronation); of trunk and neck flexion forwards, bending to the left, rotation to the
  /// left. A part of a limb points down or, the foot, forwards; a part of the trunk up.
  Eigen::Matrix3d R_FA;
  std::array<JointAxis, 3> axes;
};

/// Of a ball joint by the name of its part's joint (parts.hpp), e.g. "hip_left", "neck".
JointAxes joint_axes(std::string_view joint);

/// How far a start may lie outside a published range, which is in whole degrees, before that is told: 0.05
/// deg, in rad, so that no tenth of a degree that is shown looks as if it were inside.
inline constexpr double usual_range_room = 0.05 * std::numbers::pi / 180;

/// Widens the joint's ranges where the start (a rotation vector in its axes, rad) lies outside them, with a
/// warning per axis where it lies out by more than its deviation (rad) and usual_range_room: what the
/// landmarks leave open is no finding.
std::array<Range, 3> ranges_with_start(const JointAxes& joint, const Eigen::Vector3d& start,
                                       std::string_view name, std::vector<Warning>& warnings,
                                       const Eigen::Vector3d& deviation = Eigen::Vector3d::Zero());

/// What is said of a joint angle (rad) outside its usual range.
Warning outside_range(std::string_view joint, std::string_view motion, double angle, const Range& usual);

}  // namespace borelli
