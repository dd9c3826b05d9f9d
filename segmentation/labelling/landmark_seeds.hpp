// Parts by landmarks alone, where no bone is seen (MR): straight lines between joints stand for the bones.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Part labels along the lines between the landmarks that are there: hip to knee for a thigh and so on, the
/// column from hip to vertex by its levels; 0 elsewhere and outside the body. What soft_tissue.hpp spreads
/// from bones, it spreads from these.
Volume<std::uint8_t> seeds_by_landmarks(const Anatomy& anatomy, const Landmarks& landmarks);

}  // namespace borelli
