// What the lengths of limbs tell of their joints: left and right are nearly alike.
#pragma once

#include <string_view>

#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Places the ankles of shanks whose bones the scan's side cuts (a field of view too narrow), which hides
/// where the tibia broadens, at the other shank's length along the way; an ankle that is found stays.
void place_cut_ankles(const Trunk& trunk, const Limbs& limbs, Landmarks& marks);

/// Whether a comparison of lengths found a joint not to be where it seems.
bool is_doubted(const Landmark& mark);

/// Compares each limb's lengths from joint to joint, left with right, and with the body's size where hips and
/// shoulders both tell it (else forearms with the upper arms). Where they differ by more than those of bodies
/// do (3 % of the length) and the two joints' own deviations together, a joint is not where it seems: the one
/// that is less surely found, else the one whose limb is of unlikely length for the body, else both; of arms
/// whose bones meet always both, since what one lacks the other has, and both on `large_voxels`, where
/// another bone's end passes for a cylinder. Its deviation and its epicondyles' grow to the difference, and
/// its source ends with `unlike_other_side`, or with `unlike_body` where both sides are as unlikely.
void doubt_unlike_lengths(const Trunk& trunk, const Limbs& limbs, Landmarks& marks,
                          bool large_voxels = false);

}  // namespace borelli
