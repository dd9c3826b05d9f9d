// Whether to trust a segmentation: one word, and the reasons.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "segmentation/labelling/segment.hpp"

namespace borelli {

enum class Verdict { good, doubtful, refused };
std::string_view name_of(Verdict verdict);

struct SegmentationVerdict {
  Verdict verdict = Verdict::good;
  std::vector<std::string> reasons;  ///< sentences, the worst first; empty if good
};

/// Refused: no voxel is labelled as a part. Doubtful (body_doubts.hpp finds all but the last):
/// - a part in view has a confidence below 0.5;
/// - a part has more volume than that of a man of 250 kg; or a whole part has less than half its volume at 12
///   kg/m^2, or more than twice its volume at 60 kg/m^2, for the body's stature;
/// - a whole body has a volume that no person has, or less than 11 or more than 65 l/m^2 for its stature;
/// - left and right of a pair, both whole, differ by a quarter in volume;
/// - a joint of a part in view may lie more than 15 mm off;
/// - a large volume of a part surely belongs to another limb (second_opinion.hpp);
/// - any other warning has severity `doubt` or `fault`: a header that flips the body, flesh without a part,
///   given labels or landmarks that do not fit the scan, a voxel size that no scan has.
/// Otherwise good. A part that the scan's edge cuts is not doubtful by itself.
SegmentationVerdict verdict_of(const Segmentation& segmentation);

/// "good", or "doubtful: " with the worst reason.
std::string in_words(const SegmentationVerdict& verdict);

}  // namespace borelli
