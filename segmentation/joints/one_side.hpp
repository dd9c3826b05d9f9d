// One side of a body that the scan's side cuts lengthwise: the hip and the shoulder in view are found alone,
// and what the trunk needs of the other side is their mirror image.
#pragma once

#include "segmentation/joints/heads_in_body.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/round_heads.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Sets hips, shoulders, `only_side` and `middle_off` of a trunk of which neither pair is in view, where the
/// scan's side cuts the trunk near its middle, and a hip over its femur and a shoulder over the lung, as far
/// above as a body's, are in view. The middle lies as far inwards of the hip as an adult's of this height
/// (88 mm of 515 from hip to shoulder).
void find_one_side(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk);

/// The one shoulder in view over two hips, where the scan's side cuts off the other: that is its mirror image
/// then, out of view.
void find_one_shoulder(const Anatomy& anatomy, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk);

/// Of a trunk with one side the middle by its column, where all of that is in view; else its column in that
/// middle.
void settle_middle(const Anatomy& anatomy, Trunk& trunk);

/// The hips' middle; the other side's hip, iliac spines and (with an arm) shoulder as mirror images where the
/// column tells the middle, else none. For a trunk that shows both sides: nothing.
void mirror_sides(const Trunk& trunk, const Limbs& limbs, Landmarks& marks);

/// The column's joints in the middle where the column does not tell it, and the midline's points as uncertain
/// as it is.
void put_in_middle(const Trunk& trunk, Landmarks& marks);

/// Flesh beyond the middle is the other leg's where its mirror image is this one's, and none beyond it is
/// this side's. `owner`: the part whose flesh each place of the work grid is.
void mirror_legs(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, Volume<std::uint8_t>& owner);

}  // namespace borelli
