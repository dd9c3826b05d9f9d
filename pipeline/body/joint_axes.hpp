// Axes of a body's ball joints, and the published ranges of motion about them.
#pragma once

#include <array>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/scene/switch.hpp"
#include "segmentation/volume/warning.hpp"

namespace borelli {

/// The motion about one axis of a joint, and its published range.
struct JointAxis {
  std::string motion;  ///< as in data/joint_ranges.csv, e.g. "adduction"; empty: no published range
  Range range;         ///< rad; without a published range -pi to pi
};

struct JointAxes {
  /// R_FA: F are the anatomical axes (X forwards, Y up, Z to the right) of parent and part, which are
  /// parallel in the neutral position. The columns of A are the axes about which the three motions are
  /// positive. Limbs: flexion (ankle: dorsiflexion), adduction (wrist: ulnar deviation, ankle: inversion),
  /// internal rotation (wrist: pronation). Trunk and neck: flexion forwards, bending to the left, rotation to
  /// the left. In the neutral position limbs point down, the foot forwards, and parts of the trunk up.
  Eigen::Matrix3d R_FA;
  std::array<JointAxis, 3> axes;
};

/// Axes of a ball joint, by the name of its part's joint (parts.hpp), e.g. "hip_left", "neck".
JointAxes joint_axes(std::string_view joint);

/// Margin, rad, by which a start may lie outside a published range (whole degrees) without a warning: 0.05
/// deg. Warnings show tenths of a degree, so a smaller excess would look as if it were inside.
inline constexpr double usual_range_room = 0.05 * std::numbers::pi / 180;

/// Widens the joint's ranges to contain the start (a rotation vector in the joint's axes, rad). Warns for
/// each axis where the start lies outside by more than its deviation (rad) and usual_range_room: a smaller
/// excess is within the landmarks' uncertainty.
std::array<Range, 3> ranges_with_start(const JointAxes& joint, const Eigen::Vector3d& start,
                                       std::string_view name, std::vector<Warning>& warnings,
                                       const Eigen::Vector3d& deviation = Eigen::Vector3d::Zero());

/// Warning for a joint angle (rad) outside its usual range.
Warning outside_range(std::string_view joint, std::string_view motion, double angle, const Range& usual);

}  // namespace borelli
