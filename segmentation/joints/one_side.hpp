// One side of a body that the scan's side cuts lengthwise. The hip and shoulder in view are found alone;
// their mirror images stand for the other side.
#pragma once

#include "segmentation/joints/heads_in_body.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/round_heads.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Sets hips, shoulders, `only_side` and `middle_off` of a trunk without a pair in view, if the scan's side
/// cuts the trunk near its midline and shows a hip above its femur and a shoulder above the lung, at a
/// plausible height above the hip. The midline lies medial of the hip by an adult's half hip distance, scaled
/// by the height from hip to shoulder (88 mm per 515 mm).
void find_one_side(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk);

/// Finds the single shoulder in view above two hips, if the scan's side cuts off the other one. Sets the
/// other to its mirror image, out of view.
void find_one_shoulder(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk);

/// For a trunk with one side: sets the midline from the vertebral column if the column is wholly in view.
/// Otherwise moves the column into the assumed midline.
void settle_middle(const Anatomy& anatomy, Trunk& trunk);

/// Adds mid_hip. Replaces the other side's hip, iliac spines and (if its arm is present) shoulder by mirror
/// images if the column gives the midline; otherwise erases them. Does nothing for a trunk that shows both
/// sides.
void mirror_sides(const Trunk& trunk, const Limbs& limbs, Landmarks& marks);

/// Moves the spine's joints into the midline if the column does not give it, and adds the midline's
/// uncertainty to the midline landmarks.
void put_in_middle(const Trunk& trunk, Landmarks& marks);

/// Relabels flesh beyond the midline: as the other leg's if its mirror image, or it itself, is labelled as
/// this leg. It does so only if the column gives the midline and the other leg was not found. `owner`: part
/// label of each voxel of the work grid.
void mirror_legs(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, Volume<std::uint8_t>& owner);

}  // namespace borelli
