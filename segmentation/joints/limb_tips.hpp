// Where hands and feet end: skin's points, each looked for in the flesh of its own hand or foot.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds dactylion_3_* (the hand's skin farthest from the wrist), metacarpale_3_* (in proportion on the way to
/// it), toe_tip_* and heel_* (the foot's ends along its sole) for each wrist_* and ankle_* among `landmarks`
/// whose limb the scan does not cut. `owner` is whose flesh each place of the work grid is (labels as in
/// parts.hpp, see soft_tissue.hpp): nothing else counts, so that a hand on a thigh ends at its own finger.
/// `scale`: the body's size, see Trunk.
void find_limb_tips(const Anatomy& anatomy, const Limbs& limbs, const Volume<std::uint8_t>& owner,
                    double scale, Landmarks& landmarks);

}  // namespace borelli
