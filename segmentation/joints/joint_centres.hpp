// Joint centres and bony points of the limbs, from the way along their bones.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Landmarks of all limbs in view: hip_*, knee_* (with knee_medial_*, knee_lateral_*), ankle_*, heel_*,
/// toe_tip_*, shoulder_*, elbow_*, wrist_*, and so on (see landmarks.hpp), each with its deviation and
/// source.
void find_limb_landmarks(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs,
                         Landmarks& landmarks);

}  // namespace borelli
