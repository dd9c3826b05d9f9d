// Which side each voxel of a region of limbs belongs to.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/proposal/coarse_body.hpp"

namespace borelli {

/// Owners that part_sides gives.
enum class LimbSide : std::uint8_t { none, left, right, unknown };

/// Parts the connected regions of `limbs` (all arms, or all legs) into left and right: by ways along bones
/// from the bones next to `axial` (head and trunk), which are left or right of its middle there. Where a
/// region does not touch it, from those next to what the scan does not show, about their own middle. Regions
/// without bones there are of unknown side, and so are those within 20 mm of the middle.
std::vector<LimbSide> part_sides(const CoarseBody& body, const Mask& limbs, const Mask& axial);

}  // namespace borelli
