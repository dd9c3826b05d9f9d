// The trunk's and head's own bones by part, for the convention `bone`: skull and cervical column are head,
// the thoracic column with ribs, sternum and shoulder girdle upper trunk, the lumbar column middle trunk,
// sacrum and hip bones lower trunk.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Parts anew what label_bones gave to head and trunk: seeds stand in the column's middle between the discs
/// C7/T1, T12/L1 and L5/S1, in the skull, about the hips and the shoulders, and grow along bone. Where a disc
/// is not known, its two parts stay one: the lower.
void part_axial_bones(const Anatomy& anatomy, const Trunk& trunk, const Landmarks& landmarks,
                      Volume<std::uint8_t>& bones);

}  // namespace borelli
