#include "pipeline/given_labels.hpp"

#include <algorithm>
#include <array>

namespace borelli {
namespace {

// A part that reaches the first or last voxel along an axis is cut there.
bool touches_border(const LabelMap& labels, std::uint8_t label) {
  const auto [ni, nj, nk] = labels.grid.size;
  for (std::int64_t k = 0; k < nk; ++k)
    for (std::int64_t j = 0; j < nj; ++j) {
      const bool face = k == 0 || k == nk - 1 || j == 0 || j == nj - 1;
      for (std::int64_t i = 0; i < ni; i += face ? 1 : std::max<std::int64_t>(ni - 1, 1))
        if (labels.at(i, j, k) == label) return true;
    }
  return false;
}

}  // namespace

Segmentation segmentation_of(LabelMap labels, Landmarks landmarks) {
  Segmentation found;
  found.labels = std::move(labels);
  found.landmarks = std::move(landmarks);
  std::array<std::size_t, 256> voxels{};
  for (const auto label : found.labels.voxels) ++voxels[label];
  for (std::size_t label = 1; label < parts.size(); ++label) {
    PartFinding& part = found.part[label];
    if (found.labels.names.size() <= label || found.labels.names[label] != parts[label].name) continue;
    part.volume = static_cast<double>(voxels[label]) * found.labels.grid.voxel_volume();
    part.confidence = 1;
    if (voxels[label] == 0) continue;
    const bool cut = touches_border(found.labels, static_cast<std::uint8_t>(label));
    part.coverage = cut ? Coverage::cut : Coverage::whole;
    if (cut) part.note = "reaches the scan's edge";
  }
  return found;
}

}  // namespace borelli
