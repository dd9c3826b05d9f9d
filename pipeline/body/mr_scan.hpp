// From an MR scan to parts and masses: first its tissues, then its parts by given classes or landmarks, if
// any.
#pragma once

#include "error/error.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/mr_tissues.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Parts of an MR scan, by the classes or landmarks in `options`. Without either, the tissues are its labels,
/// every part is absent, and the first warning says so. Errors: those of segment.
Result<Segmentation> segment_mr(const MrReading& reading, const SegmentOptions& options);

/// Densities of an MR whose parts are known. Dark, thick places are lung or gas in the upper and middle trunk
/// only. Elsewhere they are dark tissue, since head and limbs hold no gas pockets of that width. Labels
/// without a part's name stay unchanged. Writes the uncertainty of the densities to `options`.
GreyVolume densities_by_parts(const MrReading& reading, const LabelMap& labels, MeasureOptions& options);

}  // namespace borelli
