// Builds a scene from an inertia table and joint centres: the body as a tree of rigid parts.
//
// The lower trunk is a free body. Spine, neck, shoulders, wrists, hips and ankles are ball joints; elbows and
// knees are hinges about the line of the epicondyles. A part's frame has its origin at the joint to its
// parent (lower trunk: midway between the hips) and, in the scan's pose, the patient's axes. The world is the
// patient frame in metres.
//
// A ball joint is zero in the anatomical position: its coordinate is the identity when the anatomical axes of
// the part (segment_frames.hpp: X forwards, Y up, Z to the right) are parallel to those of its parent. Its
// axes are those of the published ranges, signed (joint_axes.hpp) so that the left side's coordinates mirror
// the right's: x flexion, y adduction (trunk: bending to the left), z internal rotation (trunk: to the left).
// The start is the scan's pose. If it lies outside a published range, the range is widened to contain it. A
// warning follows if the excess is larger than the joint angle's deviation, which comes from the landmarks
// that define the two parts' axes.
#pragma once

#include <map>
#include <optional>
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

/// The motion of the released body: a leap from a trampoline with a tucked backward somersault. It is passive
/// except for joint springs that pull towards a tuck and stops at the ends of the ranges. There is no
/// contact; the motion ends when the gravity centre is back at its initial height.
struct Leap {
  double flight_time = 1.0;           ///< s; the gravity centre leaves upwards at g flight_time / 2
  double somersault_rate_deg = -335;  ///< deg/s about the patient's left at take-off; negative: backwards
  double tuck =
      1;  ///< 1: hips and knees flex by about 110 degrees; 0: the joints spring towards the scan's pose
  double muscle_frequency =
      1;  ///< Hz, of the passive joints: their stiffness is (2 pi f)^2 I, see joint_inertia
  double damping_ratio = 0.1;  ///< of the same joints

  // Stops of joints that have ranges (LimitSpring). Stiffness and dissipation keep this leap within the
  // ranges; the report shows it.
  static constexpr double stop_frequency = 20;     ///< Hz, as muscle_frequency
  static constexpr double stop_dissipation = 0.5;  ///< s/rad: a rebound at 1 rad/s loses a third of its speed
  static constexpr double stop_room_deg = 8;  ///< they begin so long before the end of the range, or at the
                                              ///< scan's pose where that is nearer (2 at least)
};

struct SkeletonOptions {
  std::string name = "body";
  std::optional<Leap> leap = Leap{};     ///< empty: a body at rest, without springs, for captured motion
  std::vector<std::string> absent = {};  ///< absent parts, which the scene's description names
};

struct Skeleton {
  Scene scene;
  std::vector<Warning> warnings;  ///< joints that were welded for want of a centre, parts left free ...
};

/// Builds the scene of the parts in `parts`. A part whose parent is missing is a free body; a part without a
/// joint centre is welded to its parent; each gives a warning. Fails without any part.
Result<Skeleton> build_skeleton(const PartInertials& parts, const Landmarks& landmarks,
                                const SkeletonOptions& options = {});

struct SkeletonNames {
  std::vector<std::string> solids, coordinates;
};
/// All names of solids and coordinates that a skeleton of some of these segments can have, whichever of them
/// the scan shows.
SkeletonNames skeleton_names(const std::vector<std::string>& segments);

/// The table's rows that a skeleton can be made of. Warns of rows with mass that are left out, and of parts
/// that the scan shows only in part.
PartInertials movable_parts(const InertiaTable& table, std::vector<Warning>& warnings);

/// The table's parts that the user named as absent (segmentation/vocabulary/absent_parts.hpp).
std::vector<std::string> stated_absent(const InertiaTable& table);

/// X_WS of every part's frame in the pose of the scan, in which its mesh is given.
std::map<std::string, Pose, std::less<>> scan_poses(const PartInertials& parts, const Landmarks& landmarks);

/// The moment of inertia that a joint's spring sees when it swings the two sides of the body against each
/// other about an axis through it: I1 I2 / (I1 + I2), kg m^2.
double joint_inertia(const Inertial& one_side, const Inertial& other_side, const Eigen::Vector3d& joint,
                     const Eigen::Vector3d& axis);

}  // namespace borelli
