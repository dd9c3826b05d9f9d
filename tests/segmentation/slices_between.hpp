// A piece of a volume.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

namespace borelli {

/// The slices from `first` to `last` of a volume or label map, its grid's origin moved along.
template <class Voxels>
Voxels slices_between(const Voxels& volume, std::int64_t first, std::int64_t last) {
  Voxels out = volume;
  out.grid.size[2] = last - first + 1;
  out.grid.origin = volume.grid.point(Eigen::Vector3d(0, 0, static_cast<double>(first)));
  const auto slice = static_cast<std::ptrdiff_t>(volume.grid.size[0] * volume.grid.size[1]);
  out.voxels.assign(volume.voxels.begin() + first * slice, volume.voxels.begin() + (last + 1) * slice);
  return out;
}

}  // namespace borelli
