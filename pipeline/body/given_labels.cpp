#include "pipeline/body/given_labels.hpp"

#include <array>

#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/body_doubts.hpp"
#include "segmentation/labelling/edge_contact.hpp"

namespace borelli {

Segmentation segmentation_of(LabelMap labels, Landmarks landmarks, const GreyVolume& scan, int threads) {
  Segmentation found;
  found.labels = std::move(labels);
  found.landmarks = std::move(landmarks);
  for (const auto& [name, landmark] : found.landmarks) found.given.push_back(name);
  std::array<std::size_t, 256> voxels{};
  for (const auto label : found.labels.voxels) ++voxels[label];
  const auto cut = cut_labels(found.labels, scan, threads);
  for (std::size_t label = 1; label < parts.size(); ++label) {
    PartFinding& part = found.part[label];
    if (found.labels.names.size() <= label || found.labels.names[label] != parts[label].name) continue;
    part.volume = static_cast<double>(voxels[label]) * found.labels.grid.voxel_volume();
    part.confidence = 1;
    if (voxels[label] == 0) continue;
    part.coverage = cut[label] ? Coverage::cut : Coverage::whole;
    if (cut[label])
      part.note = found.labels.labelled ? "reaches the edge of the scan or of the label map"
                                        : "reaches the edge of the scan";
  }
  warn_of_parts(found);
  return found;
}

void doubt_what_is_air(const LabelsInAir& air, Segmentation& found) {
  PartCompleteness doubts;
  doubt_what_is_air(air, found.labels, doubts);
  for (const auto& [name, doubt] : doubts) {
    const auto label = static_cast<std::size_t>(part_label(name));
    if (label == 0) continue;
    PartFinding& part = found.part[label];
    part.say(doubt.doubt);
    if (doubt.completeness != Completeness::cut) continue;
    part.coverage = Coverage::cut, part.confidence = 0;
  }
}

}  // namespace borelli
