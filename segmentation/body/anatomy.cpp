#include "segmentation/body/anatomy.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/body/body_mask.hpp"
#include "segmentation/body/tissues.hpp"
#include "segmentation/volume/held_memory.hpp"
#include "segmentation/volume/nearest_whole.hpp"

namespace borelli {

bool Anatomy::holds(const Mask& mask, const Eigen::Vector3d& point) const {
  const Eigen::Vector3d index = grid().index(point);
  const auto i = nearest_whole(index[0]), j = nearest_whole(index[1]), k = nearest_whole(index[2]);
  return grid().holds(i, j, k) && mask.at(i, j, k);
}

double Anatomy::gaps_unseen(double scale) const {
  const double largest = std::max(source->grid.spacing().maxCoeff(), step());
  return 4 * std::max(0.0, largest - 5 * scale);
}

bool Anatomy::gap_may_fuse(double scale) const {
  return std::max(source->grid.spacing().maxCoeff(), step()) > 3.5 * scale;
}

double Anatomy::over_fine() const {
  const double largest = size * std::max(std::cbrt(source->grid.voxel_volume()), step());
  return std::max(0.0, largest - 3 - 1e-6) / size;
}

bool Anatomy::near_edge(const Eigen::Vector3d& point, double reach) const {
  const auto n = static_cast<std::int64_t>(std::ceil(reach / step()));
  const Eigen::Vector3d index = grid().index(point);
  const auto i = nearest_whole(index[0]), j = nearest_whole(index[1]), k = nearest_whole(index[2]);
  for (std::int64_t c = k - n; c <= k + n; ++c)
    for (std::int64_t b = j - n; b <= j + n; ++b)
      for (std::int64_t a = i - n; a <= i + n; ++a)
        if (!grid().holds(a, b, c) || !scan.seen.at(a, b, c)) return true;
  return false;
}

void measure_depths(Anatomy& a, int threads) {
  // Voxels that the scan does not show may be body, so they are no skin.
  const Mask outside =
      where(a.grid(), [&](std::size_t o) { return !a.body.voxels[o] && a.scan.seen.voxels[o]; });
  a.depth = distance_to(outside, 200, false, threads);
  in_slabs(std::ssize(a.depth.squares), threads, [&](std::int64_t first, std::int64_t last) {
    for (auto o = static_cast<std::size_t>(first); o < static_cast<std::size_t>(last); ++o)
      if (!a.body.voxels[o]) a.depth.squares[o] = 0;
  });
  a.off_bone = distance_to(a.bone, 60, false, threads);
  a.within_bone = distance_to(complement(a.bone), 60, false, threads);
}

Anatomy anatomy_of(const GreyVolume& volume, double step, int threads) {
  return anatomy_of(volume, work_grid(volume, step, threads), threads);
}

Anatomy anatomy_of(const GreyVolume& volume, const Grid& grid, int threads) {
  Anatomy a;
  a.source = &volume;
  a.threads = threads;
  a.scan = resampled(volume, grid, threads);
  if (threads != 1) map_ahead(bytes_at_work * a.grid().count());
  a.body = body_mask(a.scan);
  a.bone = bone_mask(a.scan, a.body, threads);
  measure_depths(a, threads);
  return a;
}

}  // namespace borelli
