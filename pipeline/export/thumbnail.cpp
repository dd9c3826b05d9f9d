#include "pipeline/export/thumbnail.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "segmentation/volume/nearest_whole.hpp"
#include "threads/slabs.hpp"

namespace borelli {

namespace {

struct ShownBox {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  void hold(const Eigen::Vector3d& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

/// The patient box around an index box extended by half a voxel.
ShownBox box_of_indices(const Grid& grid, const Eigen::Vector3d& first, const Eigen::Vector3d& last) {
  ShownBox box;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int c = 0; c < 3; ++c) index[c] = corner >> c & 1 ? last[c] + 0.5 : first[c] - 0.5;
    box.hold(grid.point(index));
  }
  return box;
}

ShownBox whole_box(const Grid& grid) {
  const Eigen::Vector3d last(static_cast<double>(grid.size[0] - 1), static_cast<double>(grid.size[1] - 1),
                             static_cast<double>(grid.size[2] - 1));
  return box_of_indices(grid, Eigen::Vector3d::Zero(), last);
}

ShownBox box_to_show(const GreyVolume* grey, const LabelMap* labels) {
  constexpr double margin = 30;  // mm
  const ShownBox whole = whole_box(grey ? grey->grid : labels->grid);
  if (!labels) return whole;
  const Grid& grid = labels->grid;
  ShownBox used;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j) {
      const auto* row = labels->voxels.data() + at;
      at += static_cast<std::size_t>(grid.size[0]);
      const auto is_part = [](std::uint8_t label) { return label != 0; };
      const auto* end = row + grid.size[0];
      const auto* first = std::find_if(row, end, is_part);
      if (first == end) continue;
      const auto* back =
          std::find_if(std::reverse_iterator(end), std::reverse_iterator(row), is_part).base() - 1;
      const auto y = static_cast<double>(j), z = static_cast<double>(k);
      used.hold({static_cast<double>(first - row), y, z});
      used.hold({static_cast<double>(back - row), y, z});
    }
  if (used.low[0] > used.high[0]) return whole;
  ShownBox box = box_of_indices(grid, used.low, used.high);
  box.low = (box.low.array() - margin).matrix().cwiseMax(whole.low);
  box.high = (box.high.array() + margin).matrix().cwiseMin(whole.high);
  return box;
}

void state_range(Thumbnail& copy, const GreyVolume& grey) {
  switch (grey.quantity) {
    case Quantity::hu:
      copy.low = -1000, copy.high = 1550;
      return;  // 10 HU per step
    case Quantity::density_kgm3:
      copy.low = 0, copy.high = 2040;
      return;  // 8 kg/m^3 per step
    case Quantity::labels:
    case Quantity::mr:
      break;
  }
  // arbitrary units: the window ends at the value that 0.2 % of the voxels exceed
  std::vector<std::int16_t> some;
  const std::size_t stride = std::max<std::size_t>(1, grey.voxels.size() / 200'000);
  for (std::size_t i = 0; i < grey.voxels.size(); i += stride) some.push_back(grey.voxels[i]);
  const auto top = some.begin() + static_cast<std::ptrdiff_t>(0.998 * static_cast<double>(some.size() - 1));
  std::ranges::nth_element(some, top);
  copy.high = std::max<double>(*top, 1);
  copy.low = std::min<double>(0, *std::ranges::min_element(grey.voxels));
}

/// Trilinear value at a fractional index; outside the grid that of the nearest border voxel.
double value_at(const GreyVolume& grey, const Eigen::Vector3d& index) {
  std::array<std::array<std::size_t, 2>, 3> at;
  std::array<std::array<double, 2>, 3> weight;
  std::size_t stride = 1;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto size = grey.grid.size[c];
    const double x = std::clamp(index[static_cast<Eigen::Index>(c)], 0.0, static_cast<double>(size - 1));
    const auto cell = static_cast<std::int64_t>(x);
    const double rest = x - static_cast<double>(cell);
    weight[c] = {1 - rest, rest};
    at[c] = {stride * static_cast<std::size_t>(cell),
             stride * static_cast<std::size_t>(std::min(cell + 1, size - 1))};
    stride *= static_cast<std::size_t>(size);
  }
  double sum = 0;
  for (std::size_t c = 0; c < 2; ++c)
    for (std::size_t b = 0; b < 2; ++b)
      for (std::size_t a = 0; a < 2; ++a)
        sum += weight[0][a] * weight[1][b] * weight[2][c] * grey.voxels[at[0][a] + at[1][b] + at[2][c]];
  return sum;
}

/// Sample points of one voxel of the copy, as index displacements in the source: two along an axis on which
/// the copy's voxels are wide relative to the source's, one along the others.
std::vector<Eigen::Vector3d> sample_offsets(const Grid& grid, double spacing) {
  const Eigen::Matrix3d index_of_mm = grid.axes.inverse();
  std::vector<Eigen::Vector3d> offsets{Eigen::Vector3d::Zero()};
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector3d step = spacing * index_of_mm.col(c);  // one voxel of the copy, in source voxels
    if (step.cwiseAbs().maxCoeff() < 2) continue;
    std::vector<Eigen::Vector3d> split;
    for (const auto& offset : offsets) {
      split.push_back(offset - step / 4);
      split.push_back(offset + step / 4);
    }
    offsets = std::move(split);
  }
  return offsets;
}

/// Calls `set` with the offset of every voxel in the copy's slices [first, last) and with its centre as a
/// fractional index of `grid`. Skips voxels outside that grid.
template <class Set>
void each_voxel_in(const Grid& grid, const Thumbnail& copy, std::int64_t first, std::int64_t last,
                   Set&& set) {
  const Eigen::Matrix3d index_of_mm = grid.axes.inverse();
  const auto index_at = [&](std::int64_t i, std::int64_t j, std::int64_t k) -> Eigen::Vector3d {
    const Eigen::Vector3d steps(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    return index_of_mm * (copy.origin + copy.spacing * steps - grid.origin);
  };
  auto at = static_cast<std::size_t>(first * copy.size[0] * copy.size[1]);
  const auto visit = [&](const Eigen::Vector3d& index, std::int64_t a, std::int64_t b, std::int64_t c) {
    if (grid.holds(a, b, c)) set(at, index, grid.offset(a, b, c));
    ++at;
  };
  if (!grid.axes.isDiagonal(0)) {
    for (std::int64_t k = first; k < last; ++k)
      for (std::int64_t j = 0; j < copy.size[1]; ++j)
        for (std::int64_t i = 0; i < copy.size[0]; ++i) {
          const Eigen::Vector3d index = index_at(i, j, k);
          visit(index, nearest_whole(index[0]), nearest_whole(index[1]), nearest_whole(index[2]));
        }
    return;
  }
  // on a grid along the patient's axes each index depends on one index of the copy: computed once
  std::array<std::vector<std::pair<double, std::int64_t>>, 3> places;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::int64_t n = 0; n < copy.size[c]; ++n) {
      const double index =
          index_at(c == 0 ? n : 0, c == 1 ? n : 0, c == 2 ? n : 0)[static_cast<Eigen::Index>(c)];
      places[c].emplace_back(index, nearest_whole(index));
    }
  for (std::int64_t k = first; k < last; ++k) {
    const auto [z, c] = places[2][static_cast<std::size_t>(k)];
    for (const auto& [y, b] : places[1])
      for (const auto& [x, a] : places[0]) visit({x, y, z}, a, b, c);
  }
}

void fill_grey(Thumbnail& copy, const GreyVolume& grey, std::int64_t first, std::int64_t last) {
  const auto offsets = sample_offsets(grey.grid, copy.spacing);
  const double to_byte = 255 / (copy.high - copy.low) / static_cast<double>(offsets.size());
  each_voxel_in(grey.grid, copy, first, last, [&](std::size_t at, const Eigen::Vector3d& index, std::size_t) {
    double sum = 0;
    for (const auto& offset : offsets) sum += value_at(grey, index + offset) - copy.low;
    copy.grey[at] = static_cast<std::uint8_t>(nearest_whole(std::clamp(sum * to_byte, 0.0, 255.0)));
  });
}

void fill_labels(Thumbnail& copy, const LabelMap& labels, std::int64_t first, std::int64_t last) {
  each_voxel_in(labels.grid, copy, first, last,
                [&](std::size_t at, const Eigen::Vector3d&, std::size_t voxel) {
                  copy.labels[at] = labels.voxels[voxel];
                });
}

}  // namespace

Thumbnail thumbnail(const GreyVolume* grey, const LabelMap* labels, std::size_t most_voxels, int threads) {
  const Grid& grid = grey ? grey->grid : labels->grid;
  const ShownBox box = box_to_show(grey, labels);
  const Eigen::Vector3d extent = box.high - box.low;
  Thumbnail copy;
  copy.spacing =
      std::max(grid.spacing().minCoeff(), std::cbrt(extent.prod() / static_cast<double>(most_voxels)));
  std::size_t count = 1;
  for (int c = 0; c < 3; ++c) {
    const auto n = std::max<std::int64_t>(1, std::llround(extent[c] / copy.spacing));
    copy.size[static_cast<std::size_t>(c)] = n;
    copy.origin[c] = (box.low[c] + box.high[c] - copy.spacing * static_cast<double>(n - 1)) / 2;
    count *= static_cast<std::size_t>(n);
  }
  if (grey) {
    state_range(copy, *grey);
    copy.grey.assign(count, 0);
  }
  if (labels) copy.labels.assign(count, 0);

  in_slabs(copy.size[2], threads, [&](std::int64_t first, std::int64_t last) {
    if (grey) fill_grey(copy, *grey, first, last);
    if (labels) fill_labels(copy, *labels, first, last);
  });
  return copy;
}

}  // namespace borelli
