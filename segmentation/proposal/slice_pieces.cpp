#include "segmentation/proposal/slice_pieces.hpp"

#include <algorithm>
#include <array>

#include "segmentation/body/tissues.hpp"

namespace borelli {
namespace {

constexpr std::int32_t piece_from = 12;  // voxels: 2 cm^2

// Numbers the pieces of one slice of a mask, connected by edges (`corners`: also by corners); returns their
// sizes in voxels.
std::vector<std::int32_t> pieces_of(const Mask& mask, std::int64_t k, bool corners, std::int32_t first,
                                    std::vector<std::int32_t>& number) {
  const Grid& g = mask.grid;
  std::vector<std::int32_t> sizes;
  std::vector<std::array<std::int64_t, 2>> open;
  for (std::int64_t j = 0; j < g.size[1]; ++j)
    for (std::int64_t i = 0; i < g.size[0]; ++i) {
      const std::size_t o = g.offset(i, j, k);
      if (!mask.voxels[o] || number[o] >= 0) continue;
      const std::int32_t own = first + static_cast<std::int32_t>(sizes.size());
      sizes.push_back(0);
      open.push_back({i, j}), number[o] = own;
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        ++sizes.back();
        for (std::int64_t dy = -1; dy <= 1; ++dy)
          for (std::int64_t dx = -1; dx <= 1; ++dx) {
            if ((!corners && dx != 0 && dy != 0) || !g.holds(x + dx, y + dy, k)) continue;
            const std::size_t next = g.offset(x + dx, y + dy, k);
            if (!mask.voxels[next] || number[next] >= 0) continue;
            number[next] = own;
            open.push_back({x + dx, y + dy});
          }
      }
    }
  return sizes;
}

void measure_slice(const CoarseBody& b, std::int64_t k, SlicePieces& out,
                   std::vector<std::int32_t>& bone_number) {
  const Grid& g = b.grid();
  const auto first = static_cast<std::int32_t>(out.list.size());
  const auto sizes = pieces_of(b.body, k, false, first, out.number);
  const auto bones = pieces_of(b.bone, k, true, 0, bone_number);
  std::vector<char> counted(bones.size(), 0);
  out.list.resize(out.list.size() + sizes.size());
  struct Bounds {
    std::int64_t left = 1 << 30, right = -1, front = 1 << 30, back = -1;
  };
  std::vector<Bounds> bounds(sizes.size());
  auto& slice = out.slices[static_cast<std::size_t>(k)];
  for (std::int64_t j = 0; j < g.size[1]; ++j)
    for (std::int64_t i = 0; i < g.size[0]; ++i) {
      const std::size_t o = g.offset(i, j, k);
      if (out.number[o] < 0) continue;
      SlicePiece& piece = out.list[static_cast<std::size_t>(out.number[o])];
      Bounds& box = bounds[static_cast<std::size_t>(out.number[o] - first)];
      const double x = labelling_step * static_cast<double>(i), y = labelling_step * static_cast<double>(j);
      piece.slice = static_cast<std::int32_t>(k);
      ++piece.voxels, ++slice.voxels;
      piece.centre_x += x, piece.centre_y += y, slice.centre_x += x, slice.centre_y += y;
      box.left = std::min(box.left, i), box.right = std::max(box.right, i);
      box.front = std::min(box.front, j), box.back = std::max(box.back, j);
      if (b.hu.voxels[o] < lung_to_hu) ++piece.lung;
      if (!b.bone.voxels[o]) continue;
      ++piece.bone;
      const auto bone = static_cast<std::size_t>(bone_number[o]);
      if (bones[bone] >= 2 && !counted[bone]) counted[bone] = 1, ++piece.bones;
    }
  for (std::size_t n = 0; n < sizes.size(); ++n) {
    SlicePiece& piece = out.list[static_cast<std::size_t>(first) + n];
    piece.centre_x /= piece.voxels, piece.centre_y /= piece.voxels;
    piece.width = static_cast<std::int32_t>(labelling_step) *
                  static_cast<std::int32_t>(bounds[n].right - bounds[n].left + 1);
    piece.depth = static_cast<std::int32_t>(labelling_step) *
                  static_cast<std::int32_t>(bounds[n].back - bounds[n].front + 1);
    if (piece.voxels >= piece_from) ++slice.pieces;
  }
  if (slice.voxels > 0) slice.centre_x /= slice.voxels, slice.centre_y /= slice.voxels;
}

}  // namespace

SlicePieces slice_pieces(const CoarseBody& b) {
  SlicePieces out;
  out.number.assign(b.grid().count(), -1);
  out.slices.resize(static_cast<std::size_t>(b.grid().size[2]));
  std::vector<std::int32_t> bone_number(b.grid().count(), -1);
  for (std::int64_t k = 0; k < b.grid().size[2]; ++k) measure_slice(b, k, out, bone_number);
  return out;
}

}  // namespace borelli
