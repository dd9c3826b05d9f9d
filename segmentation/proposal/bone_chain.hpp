// Length of the chain of bones in a piece of the body.
#pragma once

#include "segmentation/grid/morphology.hpp"

namespace borelli {

/// The longest of the shortest paths along bone within `piece`, mm; paths cross gaps of up to 16 mm between
/// bones. 0 without bone.
double bone_chain_length(const Mask& piece, const Mask& bone, int threads);

}  // namespace borelli
