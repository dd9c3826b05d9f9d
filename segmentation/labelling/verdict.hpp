// Whether a segmentation is to be trusted: one word, and why.
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
  std::vector<std::string> reasons;  ///< sentences, the worst first; none of a good one
};

/// Refused: no voxel is labelled as a part. Doubtful (body_doubts.hpp finds all but the last):
/// - a part in view has a confidence below 0.5;
/// - a part holds more than that of a man of 250 kg, or, called whole, less or more than half and twice what
///   a body of its stature has at 12 and 60 kg/m^2;
/// - a whole body has a volume that no person has, or less or more than 11 and 65 l/m^2 for its stature;
/// - left and right of a pair, both whole, differ by a quarter in volume;
/// - a joint of a part in view may lie more than 15 mm off;
/// - a part holds much that surely belongs to another limb (second_opinion.hpp);
/// - any other warning says `doubt` or `fault`: a body that its header turns over, flesh without a part,
///   given labels or landmarks that do not fit the scan, a voxel size that no scan has.
/// Else it is good. A part that the scan's edge cuts is none of these by itself.
SegmentationVerdict verdict_of(const Segmentation& segmentation);

/// "good", or "doubtful: " with the worst reason.
std::string in_words(const SegmentationVerdict& verdict);

}  // namespace borelli
