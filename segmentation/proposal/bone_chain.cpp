#include "segmentation/proposal/bone_chain.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "segmentation/grid/geodesic.hpp"

namespace borelli {
namespace {

constexpr double half_gap = 8;  // mm

struct Farthest {
  std::size_t offset = 0;
  double length = 0;
};

// the bone voxel with the longest path from `start` through open voxels
Farthest farthest_bone(const Mask& open, const std::vector<std::size_t>& bones, std::size_t start,
                       int threads) {
  Volume<std::uint8_t> seeds{open.grid, std::vector<std::uint8_t>(open.grid.count())};
  seeds.voxels[start] = 1;
  const Geodesic paths =
      geodesic(Places(open.grid, threads, [&](std::size_t o) { return open.voxels[o] ? 1.0F : no_path; }),
               seeds, false);
  Farthest out{start, 0};
  for (const std::size_t o : bones)
    if (const float length = paths.length(o); length != no_path && length > out.length) out = {o, length};
  return out;
}

// The bounding box of a mask, with `extra` voxels on each side (box_around); masks are cut to it (cut_to).
struct BoneBox {
  std::array<std::int64_t, 3> low, size;
};

BoneBox box_around(const Mask& mask, std::int64_t extra) {
  const Grid& g = mask.grid;
  std::array<std::int64_t, 3> low = g.size, high{-1, -1, -1};
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!mask.at(i, j, k)) continue;
        const std::array<std::int64_t, 3> at{i, j, k};
        for (std::size_t c = 0; c < 3; ++c)
          low[c] = std::min(low[c], at[c]), high[c] = std::max(high[c], at[c]);
      }
  BoneBox box;
  for (std::size_t c = 0; c < 3; ++c) {
    box.low[c] = std::max<std::int64_t>(0, low[c] - extra);
    box.size[c] = std::max<std::int64_t>(0, std::min(g.size[c], high[c] + extra + 1) - box.low[c]);
  }
  return box;
}

Mask cut_to(const Mask& mask, const BoneBox& box) {
  Mask out;
  out.grid = mask.grid;
  out.grid.size = box.size;
  out.grid.origin = mask.grid.point(box.low[0], box.low[1], box.low[2]);
  out.voxels.resize(out.grid.count());
  for (std::int64_t k = 0; k < box.size[2]; ++k)
    for (std::int64_t j = 0; j < box.size[1]; ++j)
      for (std::int64_t i = 0; i < box.size[0]; ++i)
        out.at(i, j, k) = mask.at(i + box.low[0], j + box.low[1], k + box.low[2]);
  return out;
}

}  // namespace

double bone_chain_length(const Mask& of_piece, const Mask& of_bone, int threads) {
  const BoneBox box = box_around(of_piece, 2);
  const Mask piece = cut_to(of_piece, box), bone = cut_to(of_bone, box);
  const Mask own = where(piece.grid, [&](std::size_t o) { return piece.voxels[o] && bone.voxels[o]; });
  const Mask near = dilated(own, half_gap);
  const Mask open = where(piece.grid, [&](std::size_t o) { return piece.voxels[o] && near.voxels[o]; });
  const Regions regions = connected_regions(open, 26, threads);
  double longest = 0;
  for (std::size_t n = 0; n < std::min<std::size_t>(3, regions.list.size()); ++n) {
    std::vector<std::size_t> bones;
    for (std::size_t o = 0; o < own.voxels.size(); ++o)
      if (own.voxels[o] && regions.number.voxels[o] == static_cast<std::int32_t>(n) + 1) bones.push_back(o);
    if (bones.empty()) continue;
    // from any to one end, from there to the other
    const Farthest end = farthest_bone(open, bones, bones.front(), threads);
    longest = std::max(longest, farthest_bone(open, bones, end.offset, threads).length);
  }
  return longest;
}

}  // namespace borelli
