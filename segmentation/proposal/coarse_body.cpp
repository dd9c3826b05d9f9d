#include "segmentation/proposal/coarse_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "segmentation/volume/nearest_whole.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

Grid coarse_grid(const Grid& work) {
  Grid grid = work;
  grid.axes = labelling_step * Eigen::Matrix3d::Identity();
  for (std::size_t c = 0; c < 3; ++c) {
    const double length = work.axes(0, 0) * static_cast<double>(work.size[c] - 1);
    grid.size[c] = static_cast<std::int64_t>(std::floor(length / labelling_step + 1e-9)) + 1;
  }
  return grid;
}

}  // namespace

CoarseBody coarse_body(const Anatomy& a) {
  const Grid grid = coarse_grid(a.grid());
  GreyVolume scan{{a.grid(), a.scan.hu.voxels}, Quantity::hu};
  for (std::size_t o = 0; o < scan.voxels.size(); ++o)
    if (!a.scan.seen.voxels[o]) scan.voxels[o] = padding_hu;
  WorkVolume coarse = resampled(scan, grid, a.threads);
  CoarseBody out;
  out.threads = a.threads;
  out.hu = std::move(coarse.hu);
  out.seen = std::move(coarse.seen);
  const std::size_t count = grid.count();
  out.body = out.bone = Mask{grid, std::vector<std::uint8_t>(count)};
  out.depth.resize(count), out.off_bone.resize(count);
  const double ratio = labelling_step / a.step();
  const auto at_work = [&](std::int64_t n) { return nearest_whole(ratio * static_cast<double>(n)); };
  in_slabs(grid.size[2], a.threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k)
      for (std::int64_t j = 0; j < grid.size[1]; ++j)
        for (std::int64_t i = 0; i < grid.size[0]; ++i) {
          const std::size_t o = grid.offset(i, j, k);
          std::int16_t& hu = out.hu.voxels[o];
          hu = std::clamp<std::int16_t>(hu, -1000, 1000);
          const auto wi = at_work(i), wj = at_work(j), wk = at_work(k);
          if (!a.grid().holds(wi, wj, wk)) continue;
          const std::size_t w = a.grid().offset(wi, wj, wk);
          out.body.voxels[o] = a.body.voxels[w] && out.seen.voxels[o];
          out.bone.voxels[o] = a.bone.voxels[w];
          out.depth[o] = static_cast<std::uint8_t>(std::min(200.0F, a.depth[w]));
          out.off_bone[o] = static_cast<std::uint8_t>(std::min(60.0F, a.off_bone[w]));
        }
  });
  for (std::size_t o = 0; o < count; ++o)
    if (out.body.voxels[o]) out.places.push_back(static_cast<std::uint32_t>(o));
  return out;
}

bool at_scan_end(const CoarseBody& b, std::size_t o) {
  const Grid& g = b.grid();
  const auto n = static_cast<std::int64_t>(o);
  const std::array<std::int64_t, 3> at{n % g.size[0], n / g.size[0] % g.size[1], n / (g.size[0] * g.size[1])};
  for (std::size_t c = 0; c < 3; ++c)
    for (const std::int64_t step : {-1, 1}) {
      auto next = at;
      next[c] += step;
      if (!g.holds(next[0], next[1], next[2]) || !b.seen.at(next[0], next[1], next[2])) return true;
    }
  return false;
}

}  // namespace borelli
