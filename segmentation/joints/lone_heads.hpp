// Finds hip and shoulder of a body that lacks the other leg or arm. The missing side's joint is the mirror
// image, which the trunk's own rules need.
#pragma once

#include "segmentation/joints/heads_in_body.hpp"
#include "segmentation/joints/round_heads.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// If `trunk` has no hips, finds the one that is present: above its femur, and below the lungs or the
/// shoulders. Sets the other to its mirror image, and `no_leg` on that side. The other leg must be named in
/// `trunk.absent`, or the scan must show the place of its thigh bone without one. The hip then also replaces
/// a pair of hips, since two other round bones may pass for a pair.
void find_lone_hip(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk);

/// The same for a shoulder; needs both hips. If no arm bone lies beside the chest on one side, the mirror
/// image of the other shoulder replaces that side's sphere of a found pair. Sets `no_arm` on that side.
void find_lone_shoulder(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates,
                        Trunk& trunk);

/// Missing parts, named by the user or found missing, with the parts distal to them.
AbsentParts gone_parts(const Trunk& trunk);
/// By side: true if the leg is missing.
std::array<bool, 2> sides_without_leg(const Trunk& trunk);

/// Sets `mid_hip` of a body with one leg: the midpoint of its hip and that hip's mirror image.
void put_middle_of_hips(const Trunk& trunk, Landmarks& marks);

/// Mirrors again in the midsagittal plane of the vertebral column, once that is known.
void settle_lone_heads(Trunk& trunk);

}  // namespace borelli
