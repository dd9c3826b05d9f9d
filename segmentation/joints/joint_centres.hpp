// Joint centres and bony points of the limbs, from the paths along their bones.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds the landmarks of all limbs in view, each with its deviation and source: hip_*, knee_* (with
/// knee_medial_*, knee_lateral_*), ankle_*, shoulder_*, elbow_*, wrist_*, and so on (see landmarks.hpp).
void find_limb_landmarks(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs,
                         Landmarks& landmarks);

}  // namespace borelli
