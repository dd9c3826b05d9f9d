// Masses of parts in a phantom's scan by their labels, for comparison with the exact table.
#pragma once

#include <array>
#include <string_view>

#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli::suite {

/// Masses by label, kg, with the density curve behind the phantom's densities. Includes the skin's mixed
/// voxels, as `borelli inertia` does.
std::array<double, parts.size()> part_masses(const LabelMap& labels, const GreyVolume& grey);

/// Hands and feet.
inline bool is_end(std::string_view part) { return part.starts_with("hand") || part.starts_with("foot"); }

}  // namespace borelli::suite
