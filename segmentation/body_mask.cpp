#include "segmentation/body_mask.hpp"

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

// half the thickness below which a thing is a sheet, a finger or an ear, mm
constexpr double thin = 7.5;
// a thin thing that hangs on the body and is no longer than this belongs to it (hand with fingers spread), mm
constexpr double small_extent = 170;
// half the width of the widest passage that does not count as open to the outside air (nostrils, mouth), mm
constexpr double passage = 9;

double extent(const Region& region, double step) {
  Eigen::Vector3d d;
  for (int c = 0; c < 3; ++c)
    d[c] = static_cast<double>(region.high[static_cast<std::size_t>(c)] -
                               region.low[static_cast<std::size_t>(c)] + 1);
  return step * d.norm();
}

void drop_regions(Mask& mask, const Regions& regions, const std::vector<bool>& keep) {
  for (std::size_t o = 0; o < mask.voxels.size(); ++o) {
    const auto number = regions.number.voxels[o];
    if (number && !keep[static_cast<std::size_t>(number - 1)]) mask.voxels[o] = 0;
  }
}

// what is left when thin wide things are taken away
Mask without_sheets(const Mask& dense, double step) {
  Mask core = eroded(dense, thin, true);
  // cores of cushions and rails: small beside the body's
  const Regions cores = connected_regions(core);
  if (cores.list.empty()) return core;
  std::vector<bool> keep(cores.list.size());
  for (std::size_t n = 0; n < keep.size(); ++n)
    keep[n] = static_cast<double>(cores.list[n].voxels) > 0.005 * static_cast<double>(cores.list[0].voxels);
  drop_regions(core, cores, keep);

  const auto to_core = distance_to(core, 4 * thin);
  Mask body = dense, rest = dense;
  for (std::size_t o = 0; o < dense.voxels.size(); ++o) {
    const bool thick = to_core.voxels[o] <= static_cast<float>(thin + step);
    body.voxels[o] = dense.voxels[o] && thick;
    rest.voxels[o] = dense.voxels[o] && !thick;
  }
  const Regions pieces = connected_regions(rest);
  for (std::size_t o = 0; o < rest.voxels.size(); ++o)
    if (const auto number = pieces.number.voxels[o])
      body.voxels[o] = extent(pieces.list[static_cast<std::size_t>(number - 1)], step) < small_extent;
  return body;
}

// the largest piece and those others that can be a limb cut off by the scan's edge
void keep_pieces(Mask& body) {
  const Regions pieces = connected_regions(body);
  if (pieces.list.empty()) return;
  std::vector<bool> keep(pieces.list.size());
  for (std::size_t n = 0; n < keep.size(); ++n)
    keep[n] = static_cast<double>(pieces.list[n].voxels) > 0.003 * static_cast<double>(pieces.list[0].voxels);
  drop_regions(body, pieces, keep);
}

// Air that each slice's sides reach within the slice. Where the scan ends, a lung that it cuts is then still
// enclosed; beyond the scan's own sides all is outside.
Mask open_air(const Mask& air, const Mask& seen) {
  const auto& g = air.grid;
  Mask open{g, std::vector<std::uint8_t>(g.count(), 0)};
  std::vector<std::array<std::int64_t, 2>> stack;
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    const auto visit = [&](std::int64_t i, std::int64_t j) {
      if (i < 0 || j < 0 || i >= g.size[0] || j >= g.size[1] || open.at(i, j, k)) return;
      if (!air.at(i, j, k) && seen.at(i, j, k)) return;
      open.at(i, j, k) = 1;
      stack.push_back({i, j});
    };
    for (std::int64_t i = 0; i < g.size[0]; ++i) visit(i, 0), visit(i, g.size[1] - 1);
    for (std::int64_t j = 0; j < g.size[1]; ++j) visit(0, j), visit(g.size[0] - 1, j);
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      visit(i - 1, j), visit(i + 1, j), visit(i, j - 1), visit(i, j + 1);
    }
  }
  return open;
}

// Air that belongs to the body. The outside air is what a ball of the passage's radius reaches from the sides
// of the slices; of the air that it does not reach, hollows that are wider than a passage, or closed, are
// inside; the rest are crevices.
void fill(Mask& body, const Mask& seen) {
  const Mask air = complement(body);
  Mask wide = eroded(air, passage, true);
  const Mask start = open_air(wide, seen);
  // from slice to slice through seen air only: beyond the scan's ends lies no way into a lung
  for (std::size_t o = 0; o < wide.voxels.size(); ++o) wide.voxels[o] = wide.voxels[o] && seen.voxels[o];
  Mask flooded = reached(start, wide);
  for (std::size_t o = 0; o < wide.voxels.size(); ++o)
    flooded.voxels[o] = flooded.voxels[o] || !seen.voxels[o];
  const Mask outside = dilated(flooded, passage + 1e-3);
  Mask hollow = air;
  for (std::size_t o = 0; o < hollow.voxels.size(); ++o)
    hollow.voxels[o] = air.voxels[o] && !outside.voxels[o];
  const auto& g = body.grid;
  const Regions hollows = connected_regions(hollow, 6);
  std::vector<bool> inside(hollows.list.size(), true);
  // open crevices: touch outside air and hold no ball of the passage's size
  std::vector<float> widest(hollows.list.size(), 0);
  std::vector<std::int64_t> open(hollows.list.size(), 0);
  const auto depth = distance_to(body, 2 * passage, true);
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const auto number = hollows.number.at(i, j, k);
        if (!number) continue;
        const auto n = static_cast<std::size_t>(number - 1);
        widest[n] = std::max(widest[n], depth.at(i, j, k));
        const std::array<std::array<std::int64_t, 3>, 6> around{
            {{i - 1, j, k}, {i + 1, j, k}, {i, j - 1, k}, {i, j + 1, k}, {i, j, k - 1}, {i, j, k + 1}}};
        for (const auto& a : around)
          if (g.holds(a[0], a[1], a[2]) && outside.at(a[0], a[1], a[2]) && air.at(a[0], a[1], a[2]))
            ++open[n];
      }
  for (std::size_t n = 0; n < inside.size(); ++n)
    inside[n] = open[n] == 0 || widest[n] > static_cast<float>(passage);
  for (std::size_t o = 0; o < hollow.voxels.size(); ++o)
    if (const auto number = hollows.number.voxels[o])
      if (inside[static_cast<std::size_t>(number - 1)]) body.voxels[o] = 1;
}

}  // namespace

Mask body_mask(const WorkVolume& scan) {
  const double step = scan.hu.grid.axes.col(0).norm();
  Mask dense{scan.hu.grid, std::vector<std::uint8_t>(scan.hu.voxels.size())};
  for (std::size_t o = 0; o < dense.voxels.size(); ++o)
    dense.voxels[o] = scan.seen.voxels[o] && scan.hu.voxels[o] > skin_edge_hu;
  Mask body = without_sheets(dense, step);
  keep_pieces(body);
  fill(body, scan.seen);
  for (std::size_t o = 0; o < body.voxels.size(); ++o) body.voxels[o] = body.voxels[o] && scan.seen.voxels[o];
  return body;
}

}  // namespace borelli
