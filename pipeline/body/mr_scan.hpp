// An MR scan on its way to parts and masses: its tissues first, then parts by somebody's classes or
// landmarks, or none.
#pragma once

#include "error/error.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/mr_tissues.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Parts of an MR scan: by the classes or the landmarks of `options`; without either the tissues are its
/// labels, every part is absent, and the first warning says so. Errors: those of segment.
Result<Segmentation> segment_mr(const MrReading& reading, const SegmentOptions& options);

/// What an MR weighs once its parts are known: places that were dark and thick are lung or gas in the upper
/// and middle trunk alone, elsewhere dark tissue, since head and limbs hold no gas so wide. Labels without a
/// part's name are left as they are. `options` learns how sure those densities are.
GreyVolume densities_by_parts(const MrReading& reading, const LabelMap& labels, MeasureOptions& options);

}  // namespace borelli
