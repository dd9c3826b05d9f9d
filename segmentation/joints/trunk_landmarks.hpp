// Points of head and trunk: neck, xiphion, omphalion, anterior superior iliac spines, vertex, and the spine's
// joints at their levels.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Adds neck, cervicale, vertex, suprasternale, xiphion, omphalion, asis_*, spine_upper and spine_lower if
/// the scan contains their levels. A point that bone or skin does not show is placed by proportion, and its
/// source says so.
void find_trunk_landmarks(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs,
                          Landmarks& landmarks);

}  // namespace borelli
