// Finds landmarks of a labelled adult from the labels of its bones.
//
//   hip_*, shoulder_*
//       Centre of a sphere fitted to faces between voxels of the labelled head, within 2.5 mm of the sphere.
//       Hip: starts from faces within 16 mm of the pelvis. Shoulder: from the humerus' upper 32 mm.
//   elbow_medial_*, elbow_lateral_*, knee_medial_*, knee_lateral_*
//       Ends of the bone along its longest horizontal axis, 8 to 40 mm above its lower end.
//   elbow_*
//       Mean of the humerus' voxels within 8 mm of ulna and radius.
//   wrist_*
//       Mean of the faces between the hand's bones and ulna and radius.
//   knee_*
//       x: midpoint of the epicondyles. y: mean of the femur's lowest 36 mm. z: 20 mm above its lower end.
//   ankle_*
//       Midpoint of the outermost points of tibia and fibula in their lowest 30 mm. The joint's axis lies up to 15 mm
//       lower, near the malleoli's tips, which the labels cut off (deviation 8 mm).
//   medial_malleolus_*, lateral_malleolus_*
//       Mean of the lowest 4 mm of tibia and fibula more than 10 mm beside the ankle. The labels cut off the tips
//       (deviation 10 mm).
//   neck, t12_l1, l5_s1
//       Middle of the border between two regions of the spine, in front of the spinal cord.
//   cervicale
//       Rearmost voxel of the cervical spine's lowest 25 mm.
//   suprasternale, xiphion
//       Upper end of the sternum within 8 mm of its middle; mean of its lowest 4 mm.
//   spine_upper
//       Middle of the vertebral bodies at the xiphion's level.
//   omphalion, spine_lower
//       The deepest dent of the front skin near the middle of the lumbar spine, and the vertebral bodies at its level.
//   asis_*, psis_*
//       Frontmost and rearmost voxel of the pelvis' upper half.
//   vertex, toe_tip_*, heel_*, dactylion_3_*
//       Topmost voxel of the body. Voxel of the foot, bone or flesh, farthest from the ankle; the one farthest from
//       that toe tip. Voxel of the hand, bone or flesh, farthest from the wrist.
//   metacarpale_3_*
//       Mean of the hand's bones at 46 % of the way from wrist to dactylion.
//   mid_hip, l4_l5
//       Midpoint of the hips; middle of the spine at 20 % of the lumbar spine's height.
//
// `deviation`: standard deviation of this reading of the labels, mm.
#pragma once

#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli::suite {

struct LabelledBody;

/// The landmarks above of the body at rest, patient frame, mm. Reads the voxels, organs, owners and densities
/// of `body`.
Landmarks find_body_landmarks(const LabelledBody& body);

}  // namespace borelli::suite
