// Part seeds from landmarks alone, for scans that show no bone (MR): lines between joints stand in for the
// bones.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Part labels along the lines between the known landmarks, e.g. hip to knee for a thigh; 0 elsewhere and
/// outside the body. The spine's line from hip to vertex is divided by level. soft_tissue.hpp spreads these
/// seeds instead of bones.
Volume<std::uint8_t> seeds_by_landmarks(const Anatomy& anatomy, const Landmarks& landmarks);

}  // namespace borelli
