// Checks that segment() makes before it looks for a body.
#pragma once

#include "error/error.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Refuses, in one sentence: volumes that hold no CT numbers or densities, were padded with 0, or are larger
/// than any body; options out of range; given landmarks far outside the scan or of absent parts.
Result<void> check_scan(const GreyVolume& volume, const SegmentOptions& options);

}  // namespace borelli
