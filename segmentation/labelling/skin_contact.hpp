// Where skin touches skin: between flesh of parts that no joint joins, nothing in the scan shows the border.
#pragma once

#include <array>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

/// By part, how much of its flesh meets flesh of parts that are no neighbours of it in the body's tree (or,
/// at the shoulder, meets it beyond the reach of the joint's plane), mm^2. Of arms only: between thighs the
/// body's middle is the border.
std::array<double, parts.size()> contact_areas(const Anatomy& anatomy, const Volume<std::uint8_t>& owner,
                                               const PartPlanes& planes);

}  // namespace borelli
