// Legs alone or a head alone, in scans that show neither hips nor shoulders.
#pragma once

#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// For a trunk without hips and shoulders: sets `femur` and `scale` if the scan's upper end cuts two legs,
/// each with knee, ankle and foot bones. Otherwise sets `brain`, `spine` and `scale` if bone encloses a
/// brain. Sets nothing for knees without ankles, nor for a single leg, whose side is unknown.
void find_lone_parts(const Anatomy& anatomy, Trunk& trunk);

}  // namespace borelli
