// The bias field of a magnetic resonance image: slow brightness changes from its coils.
#pragma once

#include "error/error.hpp"
#include "segmentation/grid/morphology.hpp"

namespace borelli {

/// Bias field of `mr` as a factor about 1 (divide by it), by N4 (Tustison et al. 2010, IEEE TMI 29:1310;
/// ITK's filter), fitted to the voxels of `mask` and defined everywhere. `mr` and `mask` share a grid of at
/// most about 100000 voxels, on which the filter takes seconds; the field is smooth enough to interpolate.
/// The result is reproducible. Errors: an empty mask, and what ITK refuses.
Result<Volume<float>> bias_field(const Volume<float>& mr, const Mask& mask);

}  // namespace borelli
