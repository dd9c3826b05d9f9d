// From an inertia table and joint centres to a scene: the body as a tree of rigid parts that can move.
//
// The lower trunk is free in space; ball joints at spine, neck, shoulders, wrists, hips and ankles, hinges at
// elbows and knees about the line of the epicondyles. A part's frame has its origin at the joint to its
// parent (the lower trunk: between the hips) and, in the pose of the scan, the patient's axes; the world is
// the patient frame in metres.
//
// A ball counts from the anatomical position: its coordinate is the identity where the anatomical axes of the
// part (segment_frames.hpp: X forwards, Y up, Z to the right) are parallel to those of its parent. Its own
// axes are those about which the published ranges count, each with its sign (joint_axes.hpp), so that the
// left side's coordinates mirror the right's: x flexion, y adduction (of the trunk: bending to the left), z
// internal rotation (of the trunk: to the left). The start is the scan's pose; where that lies outside a
// published range, the range is widened to it, with a warning where it lies out by more than the joint
// angle's deviation, which is that of the landmarks that the two parts' axes are laid through.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"
#include "inertia/inertial.hpp"
#include "inertia/table.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/warning.hpp"

namespace borelli {

/// Inertial elements of each part, or group of parts (segmentation/labelling/segments.hpp), in the world
/// frame (patient axes, m), in the pose of the scan.
using PartInertials = std::map<std::string, Inertial, std::less<>>;

/// What the body does when it is let go: a leap from a trampoline with a tucked backward somersault, passive
/// but for joints that spring towards a tuck and stops at the ends of their ranges. There is no contact: it
/// ends when the gravity centre is back at its height.
struct Leap {
  double flight_time = 1.0;           ///< s; the gravity centre leaves upwards at g flight_time / 2
  double somersault_rate_deg = -335;  ///< deg/s about the patient's left at take-off; negative: backwards
  double tuck =
      1;  ///< 1: hips and knees flex by about 110 degrees; 0: the joints spring towards the scan's pose
  double muscle_frequency =
      1;  ///< Hz, of the passive joints: their stiffness is (2 pi f)^2 I, see joint_inertia
  double damping_ratio = 0.1;  ///< of the same joints

  // The stops of joints that have ranges (LimitSpring): so stiff and lossy that this leap stays within them,
  // which the report shows.
  static constexpr double stop_frequency = 20;     ///< Hz, as muscle_frequency
  static constexpr double stop_dissipation = 0.5;  ///< s/rad: at 1 rad/s a third of the speed is lost
  static constexpr double stop_room_deg = 8;  ///< they begin so long before the end of the range, or at the
                                              ///< scan's pose where that is nearer (2 at least)
};

struct SkeletonOptions {
  std::string name = "body";
  Leap leap;
  std::vector<std::string> absent = {};  ///< parts told to be absent, which the scene's description names
};

struct Skeleton {
  Scene scene;
  std::vector<Warning> warnings;  ///< joints that were welded for want of a centre, parts left free ...
};

/// Builds the scene of the parts that are there. A part whose parent is missing is free in space itself; one
/// without a joint centre is welded to its parent; both with a warning. Fails where no part is there.
Result<Skeleton> build_skeleton(const PartInertials& parts, const Landmarks& landmarks,
                                const SkeletonOptions& options = {});

struct SkeletonNames {
  std::vector<std::string> solids, coordinates;
};
/// All names that a skeleton of some of these segments can have, whatever the scan holds of them.
SkeletonNames skeleton_names(const std::vector<std::string>& segments);

/// The table's rows that a skeleton can be made of; `warnings` is told what is left out, and what is there in
/// piece.
PartInertials movable_parts(const InertiaTable& table, std::vector<Warning>& warnings);

/// The table's parts that were told to be absent (segmentation/vocabulary/absent_parts.hpp).
std::vector<std::string> told_absent(const InertiaTable& table);

/// X_WS of every part's frame in the pose of the scan, where its mesh belongs.
std::map<std::string, Pose, std::less<>> scan_poses(const PartInertials& parts, const Landmarks& landmarks);

/// The moment of inertia that a joint's spring sees when it swings the two sides of the body against each
/// other about an axis through it: I1 I2 / (I1 + I2), kg m^2.
double joint_inertia(const Inertial& one_side, const Inertial& other_side, const Eigen::Vector3d& joint,
                     const Eigen::Vector3d& axis);

}  // namespace borelli
