#include "segmentation/body/body_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "segmentation/body/tissues.hpp"

namespace borelli {
namespace {

// half the thickness below which an object counts as a sheet, a finger or an ear, mm
constexpr double thin = 7.5;
// a thin object that touches the body and is no longer than this belongs to it (a hand with spread fingers),
// mm
constexpr double small_extent = 170;
// least bone in a finger or toe separated from the body, mm^3 (the thumb's phalanges have about 2000)
constexpr double finger_bone = 250;
// widest gap across which a finger still belongs to a body, mm
constexpr double finger_gap = 10;
// half the width of the widest passage that does not open a hollow to the outside air (nostrils, mouth), mm
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

// Removes wide thin objects. Voxels that the scan does not show count as dense, so that a sliver of a limb at
// the scan's side is no sheet.
Mask without_sheets(const Mask& dense, const Mask& seen, double step) {
  const auto& g = dense.grid;
  const Mask thick =
      eroded(where(g, [&](std::size_t o) { return dense.voxels[o] || !seen.voxels[o]; }), thin, true);
  bool any = false;
  // drops small cores: those of cushions and rails
  const Mask core =
      kept_regions(where(g, [&](std::size_t o) { return thick.voxels[o] && dense.voxels[o]; }), 26,
                   [&](const Region& one, const Region& largest) {
                     any = true;
                     return static_cast<double>(one.voxels) > 0.005 * static_cast<double>(largest.voxels);
                   });
  if (!any) return core;

  const Mask near_core = dilated(core, thin + step);
  const Mask rest = where(g, [&](std::size_t o) { return dense.voxels[o] && !near_core.voxels[o]; });
  const Mask small = kept_regions(
      rest, 26, [&](const Region& one, const Region&) { return extent(one, step) < small_extent; });
  return where(g, [&](std::size_t o) { return dense.voxels[o] && (near_core.voxels[o] || small.voxels[o]); });
}

// Evidence that a small piece is a finger: bone within flesh.
struct Flesh {
  std::int64_t bone = 0, flesh = 0;  // voxels: of bone; of fat and soft tissue
  std::int64_t faces = 0, bare = 0;  // faces of its bone voxels; those at the piece's surface
  bool finger(std::int64_t voxels, double step) const {
    return static_cast<double>(bone) * step * step * step >= finger_bone && 3 * flesh >= voxels &&
           10 * bare <= faces;
  }
};

Flesh flesh_of(const Regions& pieces, std::size_t n, const Volume<std::int16_t>& hu) {
  Flesh piece;
  const Region& box = pieces.list[n];
  const auto number = static_cast<std::int32_t>(n + 1);
  const auto& g = hu.grid;
  for (std::int64_t k = box.low[2]; k <= box.high[2]; ++k)
    for (std::int64_t j = box.low[1]; j <= box.high[1]; ++j)
      for (std::int64_t i = box.low[0]; i <= box.high[0]; ++i) {
        if (pieces.number.at(i, j, k) != number) continue;
        const Tissue tissue = tissue_of(hu.at(i, j, k));
        piece.flesh += tissue == Tissue::fat || tissue == Tissue::soft;
        if (tissue != Tissue::bone) continue;
        ++piece.bone;
        const std::array<std::array<std::int64_t, 3>, 6> around{
            {{i - 1, j, k}, {i + 1, j, k}, {i, j - 1, k}, {i, j + 1, k}, {i, j, k - 1}, {i, j, k + 1}}};
        for (const auto& a : around) {
          ++piece.faces;
          piece.bare += !g.holds(a[0], a[1], a[2]) || pieces.number.at(a[0], a[1], a[2]) != number;
        }
      }
  return piece;
}

// Joins a finger to the body beside it by a row of voxels across the gap, since later steps follow flesh and
// bones outwards from the body. It attaches where the path on to the body's bone is shortest: on the hand,
// whose bones lie near the skin, and not on the thigh. False if the gap is wider than finger_gap.
bool join(Mask& body, const Regions& pieces, std::size_t finger, const Distances& off_bone, double step) {
  const Region& box = pieces.list[finger];
  const auto& g = body.grid;
  const auto n = static_cast<std::int64_t>(finger_gap / step) + 1;
  const double widest = finger_gap + step;  // between the centres of the voxels at the gap
  double best = 1e9;
  std::array<std::int64_t, 3> from{}, direction{};
  for (std::int64_t k = box.low[2]; k <= box.high[2]; ++k)
    for (std::int64_t j = box.low[1]; j <= box.high[1]; ++j)
      for (std::int64_t i = box.low[0]; i <= box.high[0]; ++i) {
        if (pieces.number.at(i, j, k) != static_cast<std::int32_t>(finger + 1)) continue;
        for (std::int64_t c = -n; c <= n; ++c)
          for (std::int64_t b = -n; b <= n; ++b)
            for (std::int64_t a = -n; a <= n; ++a) {
              if (!g.holds(i + a, j + b, k + c) || !body.at(i + a, j + b, k + c)) continue;
              const double gap = step * std::sqrt(static_cast<double>(a * a + b * b + c * c));
              const double length = gap + off_bone.at(i + a, j + b, k + c);
              if (gap > widest || length >= best) continue;
              best = length;
              from = {i, j, k};
              direction = {a, b, c};
            }
      }
  if (best == 1e9) return false;
  const std::int64_t steps =
      std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
  for (std::int64_t s = 1; s < steps; ++s) {
    const auto at = [&](std::size_t axis) {
      return from[axis] + std::lround(static_cast<double>(s * direction[axis]) / static_cast<double>(steps));
    };
    body.at(at(0), at(1), at(2)) = 1;
  }
  return true;
}

// Keeps the largest piece, other pieces large enough for a limb cut off by the scan's edge, and fingers
// separated from either by a crevice.
void keep_pieces(Mask& body, const Volume<std::int16_t>& hu, double step) {
  const Regions pieces = connected_regions(body);
  if (pieces.list.empty()) return;
  std::vector<bool> keep(pieces.list.size());
  for (std::size_t n = 0; n < keep.size(); ++n)
    keep[n] = static_cast<double>(pieces.list[n].voxels) > 0.003 * static_cast<double>(pieces.list[0].voxels);
  drop_regions(body, pieces, keep);
  Distances off_bone;
  for (std::size_t n = 0; n < keep.size(); ++n) {
    const Region& region = pieces.list[n];
    if (keep[n] || extent(region, step) >= small_extent ||
        !flesh_of(pieces, n, hu).finger(region.voxels, step))
      continue;
    if (off_bone.squares.empty()) {
      off_bone = distance_to(
          where(body.grid,
                [&](std::size_t o) { return body.voxels[o] && tissue_of(hu.voxels[o]) == Tissue::bone; }),
          60);
    }
    if (!join(body, pieces, n, off_bone, step)) continue;
    for (std::size_t o = 0; o < body.voxels.size(); ++o)
      if (pieces.number.voxels[o] == static_cast<std::int32_t>(n + 1)) body.voxels[o] = 1;
  }
}

// Fills air that belongs to the body. The outside air is what a ball of the passage's radius reaches from the
// sides of the slices. The other hollows are inside the body if they are closed or wider than a passage; the
// rest are crevices.
void fill(Mask& body, const Mask& seen) {
  const Mask air = complement(body);
  const Mask wide = eroded(air, passage, true);
  // A lung that the scan's end cuts is still enclosed within its slice. Beyond the scan's sides all is
  // outside.
  const auto& g = body.grid;
  const Mask start =
      reached_from_sides(where(g, [&](std::size_t o) { return wide.voxels[o] || !seen.voxels[o]; }));
  // from slice to slice only through seen air: no path into a lung leads through the region beyond the scan's
  // ends
  const Mask flooded =
      reached(start, where(g, [&](std::size_t o) { return wide.voxels[o] && seen.voxels[o]; }));
  const Mask outside =
      dilated(where(g, [&](std::size_t o) { return flooded.voxels[o] || !seen.voxels[o]; }), passage + 1e-3);
  const Mask hollow = where(g, [&](std::size_t o) { return air.voxels[o] && !outside.voxels[o]; });
  const Regions hollows = connected_regions(hollow, 6);
  // open crevices touch the outside air and contain no ball of the passage's size
  std::vector<bool> open(hollows.list.size()), wider(hollows.list.size());
  const Mask ball = eroded(air, passage);
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!hollow.at(i, j, k)) continue;
        const auto n = static_cast<std::size_t>(hollows.number.at(i, j, k) - 1);
        if (ball.at(i, j, k)) wider[n] = true;
        const std::array<std::array<std::int64_t, 3>, 6> around{
            {{i - 1, j, k}, {i + 1, j, k}, {i, j - 1, k}, {i, j + 1, k}, {i, j, k - 1}, {i, j, k + 1}}};
        for (const auto& a : around)
          if (g.holds(a[0], a[1], a[2]) && outside.at(a[0], a[1], a[2]) && air.at(a[0], a[1], a[2]))
            open[n] = true;
      }
  body = where(g, [&](std::size_t o) {
    if (!hollow.voxels[o]) return body.voxels[o] != 0;
    const auto n = static_cast<std::size_t>(hollows.number.voxels[o] - 1);
    return !open[n] || wider[n];
  });
}

// Keeps a lung that the scan's side cuts open: airy tissue (not air) that borders on the region out of view
// and hardly anywhere on air.
void keep_cut_lungs(Mask& body, const WorkVolume& scan, double step) {
  constexpr int emptiest_lung = -950;
  constexpr double much = 20e2, least = 30e3, most_bare = 0.1;  // mm^2; mm^3; fraction of its faces
  const auto& g = body.grid;
  const Mask airy = where(g, [&](std::size_t o) {
    return scan.seen.voxels[o] && !body.voxels[o] && scan.hu.voxels[o] > emptiest_lung &&
           scan.hu.voxels[o] <= skin_edge_hu;
  });
  const auto at_side = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i == 0 || j == 0 || i + 1 == g.size[0] || j + 1 == g.size[1] || !scan.seen.at(i - 1, j, k) ||
           !scan.seen.at(i + 1, j, k) || !scan.seen.at(i, j - 1, k) || !scan.seen.at(i, j + 1, k);
  };
  double open = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        if (airy.at(i, j, k) && at_side(i, j, k)) open += step * step;
  if (open < much) return;
  // rims of skin and cloth are airy too, but thin
  const Mask thick =
      eroded(where(g, [&](std::size_t o) { return airy.voxels[o] || !scan.seen.voxels[o]; }), thin, true);
  const Regions pieces =
      connected_regions(where(g, [&](std::size_t o) { return thick.voxels[o] && airy.voxels[o]; }), 6);
  for (std::size_t n = 0; n < pieces.list.size(); ++n) {
    if (static_cast<double>(pieces.list[n].voxels) * step * step * step < least) break;  // largest come first
    const auto number = static_cast<std::int32_t>(n + 1);
    const Mask wider =
        dilated(where(g, [&](std::size_t o) { return pieces.number.voxels[o] == number; }), thin + step);
    const Mask piece = where(g, [&](std::size_t o) { return wider.voxels[o] && airy.voxels[o]; });
    std::int64_t bare = 0, faces = 0;
    double side = 0;
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          if (!piece.at(i, j, k)) continue;
          if (at_side(i, j, k)) side += step * step;
          const std::array<std::array<std::int64_t, 3>, 6> around{
              {{i - 1, j, k}, {i + 1, j, k}, {i, j - 1, k}, {i, j + 1, k}, {i, j, k - 1}, {i, j, k + 1}}};
          for (const auto& p : around) {
            if (!g.holds(p[0], p[1], p[2]) || piece.at(p[0], p[1], p[2]) || !scan.seen.at(p[0], p[1], p[2]))
              continue;
            ++faces;
            bare += !body.at(p[0], p[1], p[2]);
          }
        }
    if (side < much || static_cast<double>(bare) > most_bare * static_cast<double>(faces)) continue;
    body = where(g, [&](std::size_t o) { return body.voxels[o] || piece.voxels[o]; });
  }
}

}  // namespace

Mask body_mask(const WorkVolume& scan) {
  const double step = scan.hu.grid.axes.col(0).norm();
  const Mask dense = where(
      scan.hu.grid, [&](std::size_t o) { return scan.seen.voxels[o] && scan.hu.voxels[o] > skin_edge_hu; });
  Mask body = without_sheets(dense, scan.seen, step);
  keep_pieces(body, scan.hu, step);
  fill(body, scan.seen);
  keep_cut_lungs(body, scan, step);
  return where(body.grid, [&](std::size_t o) { return body.voxels[o] && scan.seen.voxels[o]; });
}

}  // namespace borelli
