// Assigns the bones of head and trunk to parts for the convention `bone`. Head: skull and cervical spine.
// Upper trunk: thoracic spine, ribs, sternum and shoulder girdle. Middle trunk: lumbar spine. Lower trunk:
// sacrum and hip bones.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Relabels the bones that label_bones gave to head and trunk. Seeds grow along bone. They lie on the spine's
/// axis between the discs C7/T1, T12/L1 and L5/S1, in the skull, and around the hips and shoulders. If a disc
/// is not known, the two parts it separates stay one: the lower.
void part_axial_bones(const Anatomy& anatomy, const Trunk& trunk, const Landmarks& landmarks,
                      Volume<std::uint8_t>& bones);

}  // namespace borelli
