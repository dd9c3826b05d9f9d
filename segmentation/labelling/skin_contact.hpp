// Area where skin touches skin. There the scan does not show the border between parts that no joint connects.
#pragma once

#include <array>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

/// For each part, the area where its flesh touches flesh of parts that are not its neighbours in the body's
/// tree, mm^2. At the shoulder, contact beyond 1.5 times the reach of the joint's plane counts too. Arms
/// only: between the thighs, the midsagittal plane is the border.
std::array<double, parts.size()> contact_areas(const Anatomy& anatomy, const Volume<std::uint8_t>& owner,
                                               const PartPlanes& planes);

}  // namespace borelli
