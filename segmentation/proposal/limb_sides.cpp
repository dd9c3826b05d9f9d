#include "segmentation/proposal/limb_sides.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/grid/geodesic.hpp"

namespace borelli {
namespace {

constexpr double root_reach = 70;     // mm from the trunk: includes the humeral head and the femoral neck
constexpr double slices_about = 80;   // mm up and down, over which the middle is averaged
constexpr double beside_middle = 20;  // mm

double x_of(const Grid& g, std::size_t o) {
  return g.origin[0] + labelling_step * static_cast<double>(static_cast<std::int64_t>(o) % g.size[0]);
}
std::size_t slice_of(const Grid& g, std::size_t o) {
  return o / static_cast<std::size_t>(g.size[0] * g.size[1]);
}

// mean x of a mask over the slices near each slice; if there is none near, over the nearest ones that contain
// some
std::vector<double> middle_by_slice(const Mask& mask) {
  const Grid& g = mask.grid;
  const auto n = static_cast<std::size_t>(g.size[2]);
  std::vector<double> sums(n, 0), counts(n, 0), out(n, 0);
  for (std::size_t o = 0; o < mask.voxels.size(); ++o)
    if (mask.voxels[o]) sums[slice_of(g, o)] += x_of(g, o), ++counts[slice_of(g, o)];
  for (std::size_t k = 0; k < n; ++k)
    for (auto reach = static_cast<std::size_t>(slices_about / labelling_step);; reach *= 2) {
      double sum = 0, count = 0;
      for (std::size_t m = k > reach ? k - reach : 0; m < std::min(n, k + reach + 1); ++m)
        sum += sums[m], count += counts[m];
      if (count > 0) out[k] = sum / count;
      if (count > 0 || reach > n) break;
    }
  return out;
}

// `index`: of a point in the grid
LimbSide side_of(const Eigen::Vector3d& index, const Grid& g, const std::vector<double>& middle) {
  const double x = g.origin[0] + labelling_step * index[0];
  const auto k = static_cast<std::size_t>(std::clamp<std::int64_t>(std::llround(index[2]), 0, g.size[2] - 1));
  const double off = x - middle[k];
  if (std::abs(off) < beside_middle) return LimbSide::unknown;
  return off > 0 ? LimbSide::left : LimbSide::right;
}

// marks seeds by side at the bones near a border, given the distances to it
void add_seeds(const CoarseBody& b, const Mask& region, const Distances& to_border,
               const std::vector<double>* middle, Volume<std::uint8_t>& seeds) {
  const Mask bones = where(b.grid(), [&](std::size_t o) {
    return region.voxels[o] && b.bone.voxels[o] && to_border[o] < root_reach;
  });
  const std::vector<double> own = middle ? std::vector<double>() : middle_by_slice(bones);
  const Regions clusters = connected_regions(bones, 26, b.threads);
  constexpr std::int64_t speck = 4;  // voxels
  for (std::size_t o = 0; o < bones.voxels.size(); ++o) {
    if (!bones.voxels[o]) continue;
    const Region& cluster = clusters.list[static_cast<std::size_t>(clusters.number.voxels[o] - 1)];
    if (cluster.voxels < speck) continue;
    seeds.voxels[o] = static_cast<std::uint8_t>(side_of(cluster.centre, b.grid(), middle ? *middle : own));
  }
}

}  // namespace

std::vector<LimbSide> part_sides(const CoarseBody& b, const Mask& limbs, const Mask& axial) {
  const Grid& g = b.grid();
  std::vector<LimbSide> out(g.count(), LimbSide::none);
  const Regions regions = connected_regions(limbs, 26, b.threads);
  const Distances to_axial = distance_to(axial, 2 * root_reach, false, b.threads);
  const Mask ends = where(g, [&](std::size_t o) { return limbs.voxels[o] && at_scan_end(b, o); });
  const Distances to_end = distance_to(ends, 2 * root_reach, false, b.threads);
  std::vector<char> touches(regions.list.size(), 0);
  for (std::size_t o = 0; o < limbs.voxels.size(); ++o)
    if (limbs.voxels[o] && to_axial[o] <= 1.5 * labelling_step)
      touches[static_cast<std::size_t>(regions.number.voxels[o] - 1)] = 1;

  Volume<std::uint8_t> seeds{g, std::vector<std::uint8_t>(g.count())};
  const auto of_kind = [&](char touching) {
    return where(g, [&](std::size_t o) {
      return limbs.voxels[o] && touches[static_cast<std::size_t>(regions.number.voxels[o] - 1)] == touching;
    });
  };
  const std::vector<double> middle = middle_by_slice(axial);
  add_seeds(b, of_kind(1), to_axial, &middle, seeds);
  add_seeds(b, of_kind(0), to_end, nullptr, seeds);
  // along bone a step costs its length, off bone more, so that paths do not pass from limb to limb
  const auto cost = [&](std::size_t o) {
    if (!limbs.voxels[o]) return no_path;
    const float off = static_cast<float>(b.off_bone[o]) / 10;
    return b.bone.voxels[o] ? 1.0F : 1 + 3 * off * off;
  };
  const Volume<std::uint8_t> owner = nearest_seeds(Places(g, b.threads, cost), seeds);
  for (std::size_t o = 0; o < limbs.voxels.size(); ++o)
    if (limbs.voxels[o])
      out[o] = owner.voxels[o] ? static_cast<LimbSide>(owner.voxels[o]) : LimbSide::unknown;
  return out;
}

LimbSide side_beside(const Mask& axial, const Eigen::Vector3d& point) {
  return side_of(axial.grid.index(point), axial.grid, middle_by_slice(axial));
}

}  // namespace borelli
