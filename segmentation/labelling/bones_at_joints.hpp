// The bone layer for the convention `bone`, where nothing but the bones themselves parts the body: they are
// parted anew near each joint, by the shape of its surfaces.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Parts the bones about each joint anew, the rest of them being seeds: what lies within the ball of a
/// femoral or humeral head is the limb's, what lies beyond it medially or above is the trunk's; what lies
/// within the cylinder of the knee or elbow is the bone's above it, what lies beyond it towards the limb's
/// end is the one's below, the foremost bone at the knee is the patella, which goes with the shank; ankle and
/// wrist part level with their centres. From these seeds labels grow through bone, deep bone first, so that
/// they meet in the joint's gap. `scale`: the body's size, see Trunk.
void part_bones_at_joints(const Anatomy& anatomy, const Landmarks& landmarks, double scale,
                          Volume<std::uint8_t>& bones);

}  // namespace borelli
