// Joint centres and bony points of the limbs, from the way along their bones.
#pragma once

#include "segmentation/anatomy.hpp"
#include "segmentation/landmarks.hpp"
#include "segmentation/limbs.hpp"
#include "segmentation/trunk.hpp"

namespace borelli {

/// Where along a limb's way the lines between its bones lie, in mm from the root; 0 for one that is not in
/// view.
struct JointsAlongWay {
  double middle = 0;  ///< knee or elbow
  double end = 0;     ///< ankle or wrist
};

JointsAlongWay leg_joints(const LimbWay& way, double scale);
JointsAlongWay arm_joints(const LimbWay& way, double scale);

/// Landmarks of all limbs in view: hip_*, knee_* (with knee_medial_*, knee_lateral_*), ankle_*, heel_*,
/// toe_tip_*, shoulder_*, elbow_*, wrist_*, and so on (see landmarks.hpp), each with its deviation and
/// source.
void find_limb_landmarks(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs,
                         Landmarks& landmarks);

}  // namespace borelli
