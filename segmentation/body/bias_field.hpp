// The slow change of brightness across a magnetic resonance image, from its coils: found, to divide by.
#pragma once

#include "error/error.hpp"
#include "segmentation/grid/morphology.hpp"

namespace borelli {

/// The factor by which the same tissue is brighter at a place than on average (about 1), by N4 (Tustison et
/// al. 2010, IEEE TMI 29:1310; ITK's filter) in the voxels of `mask`; smooth, and there everywhere. `mr` and
/// `mask` on one grid of at most some 100000 voxels, for the filter takes seconds there; the field is smooth
/// enough to be interpolated. The same input gives the same field. Errors: an empty mask, what ITK refuses.
Result<Volume<float>> bias_field(const Volume<float>& mr, const Mask& mask);

}  // namespace borelli
