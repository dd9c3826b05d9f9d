#include "inertia/skin.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace borelli {
namespace {

using Index = std::array<std::int64_t, 3>;

struct Step {
  Index by;
  double length;  // mm
};

// Steps to the 26 neighbours, restricted to the allowed axes, the shortest first.
std::vector<Step> steps(const Grid& grid, const std::array<bool, 3>& allowed) {
  std::vector<Step> list;
  for (std::int64_t n = 0; n < 27; ++n) {
    const Index by{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    bool usable = n != 13;
    for (std::size_t a = 0; a < 3; ++a) usable = usable && (by[a] == 0 || allowed[a]);
    const Eigen::Vector3d d(static_cast<double>(by[0]), static_cast<double>(by[1]),
                            static_cast<double>(by[2]));
    if (usable) list.push_back({by, (grid.axes * d).norm()});
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Step& a, const Step& b) { return a.length < b.length; });
  return list;
}

Index index_of(const Grid& grid, std::size_t offset) {
  const auto n = static_cast<std::int64_t>(offset);
  return {n % grid.size[0], n / grid.size[0] % grid.size[1], n / grid.size[0] / grid.size[1]};
}

// Marks the voxels of a row that are inside the body (`body` 0: outside) and have a neighbour along an axis
// on the other side. `rows`: the row itself and its four neighbour rows; a missing neighbour is replaced by a
// row that does not differ.
void mark_border(const std::array<const std::uint8_t*, 5>& rows, std::uint8_t body, std::int64_t count,
                 std::uint8_t* marks) {
  const std::uint8_t *const row = rows[0], *const a = rows[1], *const b = rows[2], *const c = rows[3],
                            *const d = rows[4];
  const auto differs = [body](std::uint8_t label) { return static_cast<std::uint8_t>((label != 0) != body); };
  for (std::int64_t i = 0; i < count; ++i)
    marks[i] = static_cast<std::uint8_t>(differs(a[i]) | differs(b[i]) | differs(c[i]) | differs(d[i]));
  for (std::int64_t i = 1; i < count; ++i) marks[i] |= differs(row[i - 1]);
  for (std::int64_t i = 0; i + 1 < count; ++i) marks[i] |= differs(row[i + 1]);
  for (std::int64_t i = 0; i < count; ++i) marks[i] &= static_cast<std::uint8_t>(!differs(row[i]));
}

// Calls visit(offset) for each voxel inside the body (or outside) that has a neighbour along an axis on the
// other side.
template <class Visit>
void each_at_border(const LabelMap& labels, bool body, const Visit& visit) {
  const auto [nx, ny, nz] = labels.grid.size;
  const auto width = static_cast<std::size_t>(nx);
  const std::vector<std::uint8_t> same(width, body);
  std::vector<std::uint8_t> marks(width + 8);
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t j = 0; j < ny; ++j) {
      const auto row = [&](std::int64_t dj, std::int64_t dk) {
        return labels.grid.holds(0, j + dj, k + dk) ? &labels.at(0, j + dj, k + dk) : same.data();
      };
      mark_border({row(0, 0), row(-1, 0), row(1, 0), row(0, -1), row(0, 1)}, body, nx, marks.data());
      const std::size_t offset = labels.grid.offset(0, j, k);
      for (std::size_t i = 0; i < width; i += 8) {
        std::uint64_t eight;
        std::memcpy(&eight, marks.data() + i, 8);
        if (eight == 0) continue;
        for (std::size_t n = i; n < std::min(i + 8, width); ++n)
          if (marks[n]) visit(offset + n);
      }
    }
}

// number of voxels along each axis that the skin's mixture extends beyond a border
std::array<int, 3> rings_of(const Grid& grid, double blur_reach) {
  const Eigen::Vector3d spacing = grid.spacing();
  std::array<int, 3> rings;
  for (int a = 0; a < 3; ++a)
    rings[static_cast<std::size_t>(a)] = 1 + static_cast<int>(std::max(0., blur_reach) / spacing[a] + 1e-9);
  return rings;
}

}  // namespace

LabelMap grow_skin(const LabelMap& labels, double blur_reach) {
  LabelMap grown = labels;
  const Grid& grid = grown.grid;
  const std::array<int, 3> rings = rings_of(grid, blur_reach);

  std::vector<std::size_t> front, next;
  each_at_border(labels, true, [&](std::size_t offset) { front.push_back(offset); });
  for (int ring = 1; ring <= *std::max_element(rings.begin(), rings.end()); ++ring) {
    next.clear();
    for (const Step& step : steps(grid, {ring <= rings[0], ring <= rings[1], ring <= rings[2]}))
      for (const std::size_t from : front) {
        auto [i, j, k] = index_of(grid, from);
        i += step.by[0], j += step.by[1], k += step.by[2];
        if (!grid.holds(i, j, k) || grown.at(i, j, k) != 0) continue;
        grown.at(i, j, k) = grown.voxels[from];
        next.push_back(grid.offset(i, j, k));
      }
    std::swap(front, next);
  }
  return grown;
}

Result<SkinVolumes> volumes_with_skin(const LabelMap& labels, const Volume<std::int16_t>& grey,
                                      const GreyWeights& weights, const LabelMoments& grown,
                                      double blur_reach, int threads) {
  const auto bare = label_moments(labels, grey, weights, threads);
  if (!bare) return tl::unexpected(bare.error());
  const Grid& grid = labels.grid;
  const std::array<int, 3> rings = rings_of(grid, blur_reach);
  const int deepest = *std::max_element(rings.begin(), rings.end());

  struct Layer {
    std::array<double, 256> weight{}, voxels{};
    void add(std::uint8_t label, double w) { weight[label] += w, ++voxels[label]; }
  };
  Layer shell, within;  // the mixed voxels inside the border; the tissue next to them
  std::vector<bool> seen(grid.count());
  std::vector<std::size_t> front, next;
  const auto take = [&](std::size_t offset, Layer& layer) {
    seen[offset] = true;
    layer.add(labels.voxels[offset], weights[static_cast<std::size_t>(grey.voxels[offset] + 32768)]);
    next.push_back(offset);
  };
  each_at_border(labels, true, [&](std::size_t offset) { take(offset, shell); });
  const std::array<std::int64_t, 3> stride{1, grid.size[0], grid.size[0] * grid.size[1]};
  for (int ring = 2; ring <= deepest + 1; ++ring) {
    std::swap(front, next), next.clear();
    for (const std::size_t from : front) {
      const Index at = index_of(grid, from);
      for (std::size_t a = 0; a < 3; ++a)
        for (const std::int64_t by : {-1, 1}) {
          if (ring <= deepest && ring > rings[a]) continue;
          if (at[a] + by < 0 || at[a] + by >= grid.size[a]) continue;
          const auto to = static_cast<std::size_t>(static_cast<std::int64_t>(from) + by * stride[a]);
          if (labels.voxels[to] != 0 && !seen[to]) take(to, ring <= deepest ? shell : within);
        }
    }
  }

  double tissue = 0, count = 0;
  for (std::size_t label = 1; label < 256; ++label)
    tissue += within.weight[label], count += within.voxels[label];
  SkinVolumes volumes;
  for (std::size_t label = 1; label < 256; ++label) {
    const auto voxels = static_cast<double>((*bare)[label].voxels);
    volumes.all[label] = voxels;
    constexpr double few = 8;  // a part of hardly more than skin uses the others' tissue
    const double density = within.voxels[label] >= few ? within.weight[label] / within.voxels[label]
                           : count > 0                 ? tissue / count
                                                       : 0;
    if (voxels == 0 || density <= 0) continue;
    volumes.skin[label] =
        std::max(0., (grown[label].weight - (*bare)[label].weight + shell.weight[label]) / density);
    volumes.all[label] += volumes.skin[label] - shell.voxels[label];
  }
  return volumes;
}

Result<double> mixed_share(const LabelMap& labels, const Volume<std::int16_t>& grey,
                           const GreyWeights& weights) {
  if (auto checked = check_same_grid(labels, grey, weights); !checked) return tl::unexpected(checked.error());
  constexpr double water = 1000;
  std::int64_t border = 0, mixed = 0;
  each_at_border(labels, false, [&](std::size_t offset) {
    const double weight = weights[static_cast<std::size_t>(grey.voxels[offset] + 32768)];
    ++border;
    mixed += weight > 0.2 * water && weight < 0.8 * water;
  });
  return border == 0 ? 0. : static_cast<double>(mixed) / static_cast<double>(border);
}

}  // namespace borelli
