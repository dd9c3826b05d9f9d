// What the parts of a scan of the phantom weigh by their labels, to hold against the exact table.
#pragma once

#include <array>
#include <string_view>

#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli::suite {

/// kg by label, by the density curve that the phantom's own densities are from; as `borelli inertia` does,
/// the skin's mixed voxels too.
std::array<double, parts.size()> part_masses(const LabelMap& labels, const GreyVolume& grey);

/// Hands and feet.
inline bool is_end(std::string_view part) { return part.starts_with("hand") || part.starts_with("foot"); }

}  // namespace borelli::suite
