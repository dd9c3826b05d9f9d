// The planes that part one segment from the next at a joint, by convention.
//
// Body axes: up from mid_hip to neck; left from hip_right to hip_left, made square to up; front = left x up.
// deleva1996 (de Leva P (1996) J Biomech 29:1223-1230, with the cuts of Zatsiorsky and Seluyanov (1983)):
//   neck         level with the C7/T1 disc (de Leva's cervicale), square to up
//   spine_upper  through the xiphion, square to up
//   spine_lower  through the omphalion, square to up
//   hip_*        through the ASIS, holding the front axis, at 37 degrees to the sagittal plane, descending
//                towards the midline
//   shoulder_*   parallel to the sagittal plane, touching the humeral head on its medial side
//   elbow_*, wrist_*, knee_*
//                through the joint centre, halving the angle of the two long axes. The axis of a forearm or
//                shank without its far joint ends where the scan cuts its bones, or where they surely still go
//   ankle_*      through the joint centre, square to the shank's long axis
// dempster (Dempster W T (1955) WADC-TR-55-159, by the endpoints in Winter D A (2009), table 4.1), where it
// differs:
//   neck         through the C7/T1 disc, square to up (the same place; Winter's C7-T1)
//   spine_upper  through the T12/L1 disc, square to up (Winter's T12-L1)
//   spine_lower  through the L4/L5 disc, square to up (Winter's L4-L5)
//   hip_*        through the joint centre, halving the angle of trunk and thigh: Winter's thigh and pelvis
//                end at the greater trochanter, whose tip stands level with the joint centre
// bone: none.
// A plane acts only between the two parts of its joint, and no farther from its point than its reach: that of
// the shoulder ends at the armpit, below which a hanging arm may lie medial of the plane and the chest
// lateral of it.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "segmentation/vocabulary/convention.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

struct Cut {
  std::string joint;  ///< as in parts.hpp, e.g. "knee_left"
  int proximal = 0;   ///< label of the part nearer the body's root in the sense of parts.hpp (its `parent`)
  int distal = 0;     ///< label of the part that hangs on it
  Eigen::Vector3d point;                                   ///< on the plane, mm, LPS
  Eigen::Vector3d normal;                                  ///< unit, towards the distal part
  double reach = std::numeric_limits<double>::infinity();  ///< from `point`, mm
};

/// The trunk's axes in the patient frame, unit and right-handed: columns left, back, up. Needs mid_hip (or
/// both hips), neck and both hips; where some are missing, the patient axes stand in (LPS: left, back, up).
Eigen::Matrix3d trunk_axes(const Landmarks& landmarks);

/// One cut per joint whose landmarks are there; a joint without them has none.
std::vector<Cut> cut_planes(const Landmarks& landmarks, Convention convention = Convention::deleva1996);

}  // namespace borelli
