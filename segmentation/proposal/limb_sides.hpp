// Left or right for each voxel of the limbs.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "segmentation/proposal/coarse_body.hpp"

namespace borelli {

/// Result of part_sides, by voxel.
enum class LimbSide : std::uint8_t { none, left, right, unknown };

/// Divides the connected regions of `limbs` (all arms, or all legs) into left and right, by paths along
/// bones. Paths start at the bones next to `axial` (head and trunk), which lie left or right of its middle
/// there. In a region that does not touch `axial` they start at the bones next to the scan's end, left or
/// right of their own middle. Start bones within 20 mm of the middle, and regions without start bones, have
/// unknown side. Returns one entry per voxel of the body's grid.
std::vector<LimbSide> part_sides(const CoarseBody& body, const Mask& limbs, const Mask& axial);

/// Side of a point (LPS, mm) relative to the mean x of `axial` within 80 mm of its level; unknown within 20
/// mm of it.
LimbSide side_beside(const Mask& axial, const Eigen::Vector3d& point);

}  // namespace borelli
