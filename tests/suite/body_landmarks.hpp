// Landmarks of a labelled adult, from the bones' labels alone.
//
//   hip_*, shoulder_*      sphere through the labelled head's faces (in-plane faces between voxels), kept to
//                          faces within 2.5 mm of the ball; hips: faces within 16 mm of the pelvis to begin
//                          with; shoulders: of the humerus' upper 32 mm
//   elbow_medial_*, _lateral_*, knee_medial_*, _lateral_*
//                          ends of the bone along its longest horizontal axis, 8 to 40 mm above its lower end
//   elbow_*                middle of the humerus' voxels within 8 mm of ulna and radius
//   wrist_*                middle of the border of ulna+radius and hand bones
//   knee_*                 middle of the epicondyles, front to back that of the condyles, 20 mm above their
//   end medial_malleolus_*, lateral_malleolus_*
//                          ends across of tibia and fibula in their lowest 30 mm; ankle_* is their middle
//   neck, t12_l1, l5_s1    middle of the border of the two regions of the spine, before the spinal cord
//   cervicale              hindmost voxel of the cervical spine's lowest 25 mm
//   suprasternale, xiphion upper and lower end of the sternum
//   spine_upper            middle of the vertebral bodies level with the xiphion
//   omphalion, spine_lower skin in front, and vertebral bodies, level with 36 % of the lumbar spine's height:
//   no
//                          label tells the navel (deviation 12 mm)
//   asis_*                 foremost voxel of the pelvis' upper half; psis_* its hindmost
//   vertex, heel_*, toe_tip_*, dactylion_3_*
//                          highest voxel, hindmost and foremost foot, hand's farthest from the wrist
//   metacarpale_3_*        hand bones' middle at 46 % of the way from wrist to dactylion
//   mid_hip, l4_l5         between the hips; at 20 % of the lumbar spine's height
//
// A landmark's `deviation` is what this reading of the labels is unsure by, mm.
#pragma once

#include "segmentation/landmarks.hpp"

namespace borelli::suite {

struct LabelledBody;

/// The landmarks above at rest, patient frame, mm. `body` needs voxels, organs and densities only.
Landmarks find_body_landmarks(const LabelledBody& body);

}  // namespace borelli::suite
