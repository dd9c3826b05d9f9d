#include "pipeline/body/mr_scan.hpp"

#include <algorithm>
#include <array>

namespace borelli {

Result<Segmentation> segment_mr(const MrReading& reading, const SegmentOptions& options) {
  Segmentation found;
  if (options.classes || !options.given.empty()) {
    auto parted = segment(uniform_body(reading), options);
    if (!parted) return parted;
    found = std::move(*parted);
  } else {
    found.labels = reading.tissues;
    found.warnings.push_back(
        {WarningKind::body, Severity::fault,
         "MR alone does not show the parts, so the labels are the body's tissues; for parts give a label map "
         "(--labels with --label-mapping) or joints placed by hand (--landmarks)"});
  }
  add_warnings(found.warnings, WarningKind::scan, Severity::note, reading.warnings);
  return found;
}

GreyVolume densities_by_parts(const MrReading& reading, const LabelMap& labels, MeasureOptions& options) {
  options.how_sure = reading.how_sure;
  options.noise_to_contrast = reading.noise / (reading.brightness[3] - reading.brightness[2]);
  std::array<bool, 256> no_gas{};
  for (std::size_t label = 1; label < std::min<std::size_t>(256, labels.names.size()); ++label) {
    const std::string& name = labels.names[label];
    no_gas[label] = part_label(name) > 0 && name != "upper_trunk" && name != "middle_trunk";
  }
  GreyVolume density = reading.density;
  constexpr auto dark = static_cast<std::size_t>(MrTissue::dark),
                 gas = static_cast<std::size_t>(MrTissue::gas);
  for (std::size_t o = 0; o < std::min(density.voxels.size(), labels.voxels.size()); ++o)
    if (no_gas[labels.voxels[o]] && density.voxels[o] == mr_tissue_density[gas])
      density.voxels[o] = static_cast<std::int16_t>(mr_tissue_density[dark]);
  return density;
}

}  // namespace borelli
