#include "segmentation/labelling/verdict.hpp"

#include <algorithm>

namespace borelli {

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::good:
      return "good";
    case Verdict::doubtful:
      return "doubtful";
    case Verdict::refused:
      return "refused";
  }
  return "";
}

SegmentationVerdict verdict_of(const Segmentation& segmentation) {
  std::vector<Warning> grave;
  std::ranges::copy_if(segmentation.warnings, std::back_inserter(grave),
                       [](const Warning& warning) { return warning.severity > Severity::note; });
  const bool labelled =
      std::ranges::any_of(segmentation.part, [](const PartFinding& finding) { return finding.volume > 0; });
  SegmentationVerdict verdict{!labelled        ? Verdict::refused
                              : !grave.empty() ? Verdict::doubtful
                                               : Verdict::good,
                              in_sentences(grave)};
  if (!labelled && grave.empty()) verdict.reasons = {"no voxel is labelled as a part of the body"};
  return verdict;
}

std::string in_words(const SegmentationVerdict& verdict) {
  return std::string(name_of(verdict.verdict)) +
         (verdict.reasons.empty() ? "" : ": " + verdict.reasons.front());
}

}  // namespace borelli
