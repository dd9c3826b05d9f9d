// Binary masks on an isotropic grid: distances, erosion and dilation, connected regions.
//
// Erosion and dilation use balls, as thresholds of the exact Euclidean distance map (Felzenszwalb &
// Huttenlocher 2012, Theory of Computing 8:415). So their radius is in mm and not in voxels.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "segmentation/volume/volume.hpp"
#include "threads/slabs.hpp"

namespace borelli {

using Mask = Volume<std::uint8_t>;  ///< 0 or 1

/// Mask that is 1 where holds(offset).
template <class Holds>
Mask where(const Grid& grid, const Holds& holds) {
  Mask out{grid, std::vector<std::uint8_t>(grid.count())};
  in_slabs(std::ssize(out.voxels), 0, [&](std::int64_t first, std::int64_t last) {
    // Fill a local buffer first: the compiler must assume that writes to bytes of `out` may alias what
    // `holds` reads.
    std::array<std::uint8_t, 4096> some;
    while (first < last) {
      const std::int64_t count = std::min(last - first, std::ssize(some));
      for (std::int64_t n = 0; n < count; ++n)
        some[static_cast<std::size_t>(n)] = holds(static_cast<std::size_t>(first + n));
      std::copy_n(some.begin(), count, out.voxels.begin() + first);
      first += count;
    }
  });
  return out;
}

/// Distances in mm, each stored in two bytes as its square in voxels.
struct Distances {
  Grid grid;
  std::vector<std::uint16_t> squares;  ///< grid.count(), i fastest
  float step = 0;                      ///< mm
  std::uint16_t too_far = 0;           ///< the square that stands for `reach`
  float reach = 0;                     ///< mm

  float operator[](std::size_t o) const {
    return squares[o] < too_far ? step * std::sqrt(static_cast<float>(squares[o])) : reach;
  }
  float at(std::int64_t i, std::int64_t j, std::int64_t k) const { return (*this)[grid.offset(i, j, k)]; }
};

/// Distance in mm from each voxel centre to the nearest set voxel's centre (0 on set voxels). Voxels farther
/// than `reach`, or 256 voxels away or more, get `reach`. The grid must be isotropic and orthogonal.
/// `outside_is_set`: voxels outside the grid count as set.
Distances distance_to(const Mask& mask, double reach, bool outside_is_set = false, int threads = 0);
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

/// A number per voxel, in memory that is not initialised.
struct RegionNumbers {
  Grid grid;
  std::unique_ptr<std::int32_t[]> voxels;  ///< grid.count(), i fastest

  std::int32_t at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return voxels[grid.offset(i, j, k)];
  }
};

struct Regions {
  RegionNumbers number;      ///< 0 outside the mask, else 1 + index into `list`
  std::vector<Region> list;  ///< largest first
};

/// Connected regions of a mask, neighbours by faces (6) or by faces, edges and corners (26).
Regions connected_regions(const Mask& mask, int neighbours = 26, int threads = 0);

/// The regions of a mask for which keep(region, largest region) is true.
Mask kept_regions(const Mask& mask, int neighbours,
                  const std::function<bool(const Region& region, const Region& largest)>& keep);

/// The part of `mask` that is connected (by faces) to a voxel of `seed`.
Mask reached(const Mask& seed, const Mask& mask);

/// The part of `mask` that is connected to a side of its slice (square to k), by faces and within the slice.
Mask reached_from_sides(const Mask& mask);

}  // namespace borelli
