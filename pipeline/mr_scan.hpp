// An MR scan on its way to parts and masses: its tissues first, then parts by somebody's classes or
// landmarks, or none.
#pragma once

#include "error/error.hpp"
#include "segmentation/mr_tissues.hpp"
#include "segmentation/segment.hpp"

namespace borelli {

/// Parts of an MR scan: by the classes or the landmarks of `options`; without either the tissues are its
/// labels, every part is absent, and the first warning says so. Errors: those of segment.
Result<Segmentation> segment_mr(const MrReading& reading, const SegmentOptions& options);

}  // namespace borelli
