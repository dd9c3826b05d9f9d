// Ends of hands and feet: points on the skin, each searched only in the flesh of its own hand or foot.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds dactylion_3_* (skin of the hand farthest from the wrist), metacarpale_3_* (by proportion between
/// wrist and dactylion), toe_tip_* and heel_* (ends of the foot along its sole) for each wrist_* and ankle_*
/// in `landmarks` whose limb the scan does not cut. `owner`: part label of each voxel of the work grid
/// (parts.hpp, soft_tissue.hpp); a hand on a thigh thus ends at its own finger. `scale`: the body's size, see
/// Trunk.
void find_limb_tips(const Anatomy& anatomy, const Limbs& limbs, const Volume<std::uint8_t>& owner,
                    double scale, Landmarks& landmarks);

}  // namespace borelli
