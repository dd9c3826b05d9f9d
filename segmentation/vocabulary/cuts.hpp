// The planes that separate neighbouring segments at each joint, by convention.
//
// Body axes: up from mid_hip to neck; left from hip_right to hip_left, orthogonalised against up;
// front = left x up.
// deleva1996 (de Leva P (1996) J Biomech 29:1223-1230, with the cuts of Zatsiorsky and Seluyanov (1983)):
//   neck         level with the C7/T1 disc (de Leva's cervicale), perpendicular to up
//   spine_upper  through the xiphion, perpendicular to up
//   spine_lower  through the omphalion, perpendicular to up
//   hip_*        through the ASIS, containing the front axis, at 37 degrees to the sagittal plane, descending
//                towards the midline
//   shoulder_*   parallel to the sagittal plane, tangent to the humeral head on its medial side
//   elbow_*, wrist_*, knee_*
//                through the joint centre, bisecting the angle between the two long axes. If the far joint of
//                a forearm or shank is not known, its axis ends where the scan cuts its bones, or at the last
//                place where its bones are certain
//   ankle_*      through the joint centre, perpendicular to the shank's long axis
// dempster (Dempster W T (1955) WADC-TR-55-159, by the endpoints in Winter D A (2009), table 4.1), where it
// differs:
//   neck         through the C7/T1 disc, perpendicular to up (the same place; Winter's C7-T1)
//   spine_upper  through the T12/L1 disc, perpendicular to up (Winter's T12-L1)
//   spine_lower  through the L4/L5 disc, perpendicular to up (Winter's L4-L5)
//   hip_*        through the joint centre, bisecting the angle of trunk and thigh: Winter's thigh and pelvis
//                end at the greater trochanter, whose tip is level with the joint centre
// bone: none.
// A plane acts only between the two parts of its joint, and only within its reach, measured from its point.
// The shoulder's reach ends at the armpit: below it a hanging arm may lie medial of the plane, and the chest
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
  int distal = 0;     ///< label of its child in parts.hpp
  Eigen::Vector3d point;                                   ///< on the plane, mm, LPS
  Eigen::Vector3d normal;                                  ///< unit, towards the distal part
  double reach = std::numeric_limits<double>::infinity();  ///< from `point`, mm
};

/// The trunk's axes in the patient frame (LPS): 3 x 3, orthonormal and right-handed, columns left, back, up.
/// Uses mid_hip (or both hips), neck and both hips. A missing direction falls back to the patient axis (LPS:
/// left, back, up).
Eigen::Matrix3d trunk_axes(const Landmarks& landmarks);

/// One cut per joint whose landmarks are known; joints without them have none.
std::vector<Cut> cut_planes(const Landmarks& landmarks, Convention convention = Convention::deleva1996);

}  // namespace borelli
