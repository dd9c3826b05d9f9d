// How long a chain of bones a piece of the body holds.
#pragma once

#include "segmentation/grid/morphology.hpp"

namespace borelli {

/// Length of the longest of the shortest ways along bone within `piece`, mm; gaps of up to 16 mm between
/// bones are crossed. 0 without bone.
double bone_chain_length(const Mask& piece, const Mask& bone, int threads);

}  // namespace borelli
