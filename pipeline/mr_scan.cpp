#include "pipeline/mr_scan.hpp"

namespace borelli {

Result<Segmentation> segment_mr(const MrReading& reading, const SegmentOptions& options) {
  Segmentation found;
  if (options.classes || !options.given.empty()) {
    auto parted = segment(flat_body(reading), options);
    if (!parted) return parted;
    found = std::move(*parted);
  } else {
    found.labels = reading.tissues;
    found.warnings.push_back(
        "no part can be told in MR by itself: the labels are the body's tissues. Parts come from a label map "
        "(--labels with --label-mapping) or from joints placed by hand (--landmarks)");
  }
  found.warnings.insert(found.warnings.end(), reading.warnings.begin(), reading.warnings.end());
  return found;
}

}  // namespace borelli
