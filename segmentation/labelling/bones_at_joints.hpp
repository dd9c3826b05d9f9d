// The bone layer for the convention `bone`, where only the bones separate the parts. Bones near each joint
// are relabelled by the shape of the joint surfaces.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Relabels the bones around each joint; bones farther away are seeds.
///
/// - Hip, shoulder: the ball of the femoral or humeral head belongs to the limb. Bone beyond it medially or
///   above belongs to the trunk.
/// - Knee, elbow: the fitted cylinder belongs to the proximal bone, and bone distal of it to the distal bone.
///   The foremost bone at the knee is the patella; it belongs to the shank.
/// - Ankle, wrist: bones are divided at the level of the joint centre.
///
/// From these seeds labels grow through bone, deep bone first, and meet in the joint space. `scale`: the
/// body's size, see Trunk.
void part_bones_at_joints(const Anatomy& anatomy, const Landmarks& landmarks, double scale,
                          Volume<std::uint8_t>& bones);

}  // namespace borelli
