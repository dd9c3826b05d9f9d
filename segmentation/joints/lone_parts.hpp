// Legs alone, and a head alone: what a scan holds that shows neither hips nor shoulders.
#pragma once

#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// Sets `femur` and `scale` of a trunk without hips and shoulders where the scan's upper end cuts two legs
/// that both show a knee, an ankle and bones of a foot beyond; else `brain`, `spine` and `scale` where bone
/// encloses a brain. Knees without ankles, and single legs, whose side nothing tells, are neither.
void find_lone_parts(const Anatomy& anatomy, Trunk& trunk);

}  // namespace borelli
