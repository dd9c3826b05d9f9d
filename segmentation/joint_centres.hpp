// Joint centres and bony points of the limbs, from the way along their bones.
#pragma once

#include "segmentation/anatomy.hpp"
#include "segmentation/landmarks.hpp"
#include "segmentation/limbs.hpp"
#include "segmentation/trunk.hpp"

namespace borelli {

/// Landmarks of all limbs in view: hip_*, knee_* (with knee_medial_*, knee_lateral_*), ankle_*, heel_*,
/// toe_tip_*, shoulder_*, elbow_*, wrist_*, and so on (see landmarks.hpp), each with its deviation and
/// source.
void find_limb_landmarks(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs,
                         Landmarks& landmarks);

}  // namespace borelli
