// Binary masks on an isotropic grid: distances, growth, connected regions.
//
// Erosion and dilation are by balls, as thresholds of the exact Euclidean distance map (Felzenszwalb &
// Huttenlocher 2012, Theory of Computing 8:415), so their radius is in mm and not in voxels.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "segmentation/volume.hpp"

namespace borelli {

using Mask = Volume<std::uint8_t>;  ///< 0 or 1

/// Distance in mm from each voxel centre to the nearest set voxel's centre (0 on set voxels), no greater than
/// `reach` (farther voxels hold `reach`). The grid must be isotropic and orthogonal. What lies outside the
/// grid counts as `outside_is_set` says.
Volume<float> distance_to(const Mask& mask, double reach, bool outside_is_set = false, int threads = 0);

/// Voxels whose distance to the mask's complement exceeds `radius` mm; outside the grid is complement unless
/// `outside_is_set`.
Mask eroded(const Mask& mask, double radius, bool outside_is_set = false);
/// Voxels within `radius` mm of the mask.
Mask dilated(const Mask& mask, double radius);
Mask complement(const Mask& mask);

struct Region {
  std::int64_t voxels = 0;
  std::array<std::int64_t, 3> low{0, 0, 0}, high{0, 0, 0};  ///< bounding box in voxels, both ends included
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();         ///< mean of the voxel indices
};

struct Regions {
  Volume<std::int32_t> number;  ///< 0 outside the mask, else 1 + index into `list`
  std::vector<Region> list;     ///< largest first
};

/// Connected regions of a mask, neighbours by faces (6) or by faces, edges and corners (26).
Regions connected_regions(const Mask& mask, int neighbours = 26);

/// The part of `mask` that is connected (by faces) to a voxel of `seed`.
Mask reached(const Mask& seed, const Mask& mask);

/// The part of `mask` that is connected to a side of its slice (square to k), by faces and within the slice.
Mask reached_from_sides(const Mask& mask);

}  // namespace borelli
