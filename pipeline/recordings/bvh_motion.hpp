// Where the joints of a BVH file are: poses per frame, and joint centres as markers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "pipeline/recordings/bvh_file.hpp"
#include "pipeline/recordings/marker_motion.hpp"

namespace borelli {

/// What position channels mean beside the joint's OFFSET.
enum class BvhPositions {
  added,     ///< to the offset: the published definition
  replaced,  ///< they are the place in the parent, and the offset is that of the rest pose: Blender
  by_data    ///< decided for each joint, see replaces_offset
};

/// Whether the position channels of a joint hold its offset too, as their mean p over all frames says: where
/// p . o > |o|^2 / 2, the values lie nearer to the offset o than to zero (least squares over the axes that
/// have a channel). False without position channels, frames or an offset along them.
bool replaces_offset(const BvhMotion& motion, std::size_t joint);

/// The pose X_WJ of every joint in one frame, in the order of `motion.joints`: p in the file's unit. In its
/// parent P: p_PJ is the offset and the position channels, R_PJ the product of the rotations from left to
/// right, so that Zrotation Xrotation Yrotation is Rz Rx Ry (Meredith and Maddock 2001).
/// Rotations turn the joint's children, not its own place. `frame`: 0 to rows - 1.
std::vector<Pose> bvh_poses(const BvhMotion& motion, Eigen::Index frame,
                            BvhPositions positions = BvhPositions::by_data);

/// The same in the rest pose, where all channels are zero.
std::vector<Pose> bvh_rest_poses(const BvhMotion& motion);

/// Metres of the file's unit, guessed: BVH files do not name it. The longest side of the box around the
/// skeleton's rest pose is taken for its height; the unit is m, dm, cm or mm, whichever makes it 0.3 to 3 m.
/// Empty: there is none, or the skeleton has no extent. (Files in inches, or of Carnegie Mellon's database in
/// 0.45 inches, are taken for decimetres or centimetres: give their unit.)
std::optional<double> guessed_bvh_unit(const BvhMotion& motion);

/// Joint centres and End Sites as markers, by the joints' names; times are whole frame times from zero.
/// `metres`: of the file's unit. The file does not tell which way is up. Errors: no frames; `metres` not
/// above zero; more than the memory limit. `file`: for errors.
Result<MarkerMotion> bvh_markers(const BvhMotion& motion, double metres, const std::string& file,
                                 BvhPositions positions = BvhPositions::by_data);

}  // namespace borelli
