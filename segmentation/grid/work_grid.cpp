#include "segmentation/grid/work_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "segmentation/volume/nearest_whole.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// air around the dense region, mm; and the limit of what counts as dense: above air's noise, and a table's
// foam may stay out
constexpr double margin = 30;
constexpr double air_to_hu = -500;

int padding_of(const GreyVolume& volume) { return volume.quantity == Quantity::hu ? -1024 : 0; }

// Trilinear value at (tx, ty, tz) between eight voxels, the first at `p`, rows and slices `sy` and `sz`
// apart; false if one of them is padding.
inline bool between(const std::int16_t* p, std::int64_t sy, std::int64_t sz, int padding, double tx,
                    double ty, double tz, double& value) {
  const int least = std::min({p[0], p[1], p[sy], p[sy + 1], p[sz], p[sz + 1], p[sz + sy], p[sz + sy + 1]});
  if (least < padding) return false;
  const auto line = [&](const std::int16_t* q) { return q[0] + tx * (q[1] - q[0]); };
  const double low_face = line(p) + ty * (line(p + sy) - line(p));
  const double high_face = line(p + sz) + ty * (line(p + sz + sy) - line(p + sz));
  value = low_face + tz * (high_face - low_face);
  return true;
}

// True if one of `count` voxels exceeds a value. (Comparing all of them vectorises and is faster than
// stopping early.)
bool any_above(const std::int16_t* voxels, std::int64_t count, std::int16_t value) {
  std::int16_t most = std::numeric_limits<std::int16_t>::min();
  for (std::int64_t i = 0; i < count; ++i) most = std::max(most, voxels[i]);
  return most > value;
}

// The largest value that stands for at most air_to_hu.
std::int16_t still_air(Quantity quantity) {
  std::int16_t value = std::numeric_limits<std::int16_t>::min();
  while (hu_of(value + 1, quantity) <= air_to_hu) ++value;
  return value;
}

// Weights for the means over the work voxels along one axis: each mean takes `weights` of the scan's voxels
// from `first` on, all of one length. `inside` is 0 if a sample lies outside the scan or not between two of
// its voxels.
struct Windows {
  std::vector<std::size_t> first;
  std::vector<char> inside;
  std::vector<std::vector<double>> weights;  // [voxel after the first][work voxel]

  explicit Windows(std::size_t count) : first(count), inside(count, 1) {}
  // Adds work voxel m: the mean of samples at these indices.
  void add(std::size_t m, std::span<const double> samples, std::int64_t size) {
    const auto [low, high] = std::minmax(samples.front(), samples.back());
    inside[m] = low >= 0 && static_cast<std::int64_t>(high) + 1 < size;
    if (!inside[m]) return;
    first[m] = static_cast<std::size_t>(low);
    for (const double at : samples) {
      const double cell = std::floor(at), part = 1 / static_cast<double>(samples.size());
      const auto n = static_cast<std::size_t>(cell) - first[m];
      while (weights.size() < n + 2) weights.emplace_back(first.size(), 0.0);
      weights[n][m] += part * (1 - (at - cell));
      weights[n + 1][m] += part * (at - cell);
    }
  }
};

// Some rows of the scan (or of sums of them), each with its weight in a mean.
template <class T>
struct WeightedRows {
  std::vector<const T*> rows;
  std::vector<double> weights;

  void clear() { rows.clear(), weights.clear(); }
  void add(const T* row, double weight) { rows.push_back(row), weights.push_back(weight); }
};

// sum = (begin ? 0 : sum) + the next n weighted rows from `first` on, in one pass over the data
template <int n, class T>
void sum_of(const WeightedRows<T>& from, std::size_t first, bool begin, std::size_t count, double* sum) {
  std::array<const T*, n> rows;
  std::array<double, n> weights;
  for (std::size_t r = 0; r < n; ++r) rows[r] = from.rows[first + r], weights[r] = from.weights[first + r];
  for (std::size_t i = 0; i < count; ++i) {
    double value = begin ? 0 : sum[i];
    for (std::size_t r = 0; r < n; ++r) value += weights[r] * rows[r][i];
    sum[i] = value;
  }
}

template <class T>
void sum_of(const WeightedRows<T>& from, std::size_t count, double* sum) {
  for (std::size_t first = 0; first < from.rows.size();) {
    const std::size_t left = from.rows.size() - first;
    if (left >= 4)
      sum_of<4>(from, first, first == 0, count, sum), first += 4;
    else if (left == 3)
      sum_of<3>(from, first, first == 0, count, sum), first += 3;
    else if (left == 2)
      sum_of<2>(from, first, first == 0, count, sum), first += 2;
    else
      sum_of<1>(from, first, first == 0, count, sum), first += 1;
  }
}

// The minimum and the maximum of each column over some rows.
struct Extremes {
  std::vector<std::int16_t> least, most;

  explicit Extremes(std::size_t n) : least(n), most(n) {}
  // `begin`: starts anew with this row
  void add(bool begin, std::size_t count, const std::int16_t* low, const std::int16_t* high) {
    for (std::size_t i = 0; i < count; ++i) {
      least[i] = begin ? low[i] : std::min(least[i], low[i]);
      most[i] = begin ? high[i] : std::max(most[i], high[i]);
    }
  }
};

// By slice: 1 if it contains padding.
std::vector<char> padded_slices(const GreyVolume& volume, int padding, int threads) {
  std::vector<char> padded(static_cast<std::size_t>(volume.grid.size[2]));
  const auto slice = static_cast<std::size_t>(volume.grid.size[0] * volume.grid.size[1]);
  in_slabs(volume.grid.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (auto k = static_cast<std::size_t>(k0); k < static_cast<std::size_t>(k1); ++k) {
      const std::int16_t* const voxels = volume.voxels.data() + k * slice;
      std::int16_t least = std::numeric_limits<std::int16_t>::max();
      for (std::size_t i = 0; i < slice; ++i) least = std::min(least, voxels[i]);
      padded[k] = least < padding;
    }
  });
  return padded;
}

}  // namespace

bool sample(const GreyVolume& volume, const Vector3d& index, double& value) {
  const int padding = padding_of(volume);
  const auto& g = volume.grid;
  // fast path: well inside and without padding, eight voxels at fixed offsets
  const auto x = static_cast<std::int64_t>(index[0]), y = static_cast<std::int64_t>(index[1]),
             z = static_cast<std::int64_t>(index[2]);
  if (index.minCoeff() >= 0 && x + 1 < g.size[0] && y + 1 < g.size[1] && z + 1 < g.size[2]) {
    const auto sy = g.size[0], sz = g.size[0] * g.size[1];
    const std::int16_t* p = &volume.voxels[static_cast<std::size_t>(z * sz + y * sy + x)];
    if (between(p, sy, sz, padding, index[0] - static_cast<double>(x), index[1] - static_cast<double>(y),
                index[2] - static_cast<double>(z), value))
      return true;
  }
  std::array<std::int64_t, 3> low{}, high{};
  Vector3d t;
  for (int c = 0; c < 3; ++c) {
    const auto n = static_cast<double>(g.size[static_cast<std::size_t>(c)]);
    if (index[c] < -0.5 || index[c] > n - 0.5) return false;
    const double at = std::clamp(index[c], 0.0, n - 1);
    low[static_cast<std::size_t>(c)] = static_cast<std::int64_t>(at);
    high[static_cast<std::size_t>(c)] =
        std::min(low[static_cast<std::size_t>(c)] + 1, g.size[static_cast<std::size_t>(c)] - 1);
    t[c] = at - std::floor(at);
  }
  double sum = 0, padded = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool a = corner & 1, b = corner & 2, c = corner & 4;
    const double w = (a ? t[0] : 1 - t[0]) * (b ? t[1] : 1 - t[1]) * (c ? t[2] : 1 - t[2]);
    const int v = volume.at(a ? high[0] : low[0], b ? high[1] : low[1], c ? high[2] : low[2]);
    sum += w * std::max(v, padding);
    if (v < padding) padded += w;
  }
  value = sum;
  return padded < 0.5;
}

double hu_of(double value, Quantity quantity) {
  if (quantity != Quantity::density_kgm3) return value;
  // unit slope up to 1100 kg/m3 (air -1000, water 0, skin 90), then up to bone's 1.25 per kg/m3 by 1200
  // (Schneider et al. 1996, Phys Med Biol 41:111, and the CT numbers of the ICRP 110 media)
  if (value <= 1100) return value - 1000;
  if (value >= 1200) return 1.25 * (value - 1000);
  return 100 + (value - 1100) * 1.5;
}

Grid work_grid(const GreyVolume& volume, double step, int threads) {
  const Grid& grid = volume.grid;
  struct Box {
    Vector3d low = Vector3d::Constant(1e30), high = Vector3d::Constant(-1e30);
    void add(const Box& other) {
      low = low.cwiseMin(other.low);
      high = high.cwiseMax(other.high);
    }
  };
  Box scan;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d index;
    for (int c = 0; c < 3; ++c)
      index[c] = corner >> c & 1 ? static_cast<double>(grid.size[static_cast<std::size_t>(c)]) - 0.5 : -0.5;
    scan.add({grid.point(index), grid.point(index)});
  }
  // bounds of all that is denser than air, row by row: positions along a row are linear, so its ends bound it
  std::vector<Box> by_slice(static_cast<std::size_t>(grid.size[2]));
  const std::int16_t air = still_air(volume.quantity);
  constexpr std::int64_t together = 64;
  in_slabs(grid.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < grid.size[1]; ++j) {
        const auto* row = &volume.voxels[grid.offset(0, j, k)];
        std::int64_t first = 0, last = grid.size[0] - 1;
        while (last - first >= together && !any_above(row + first, together, air)) first += together;
        while (first <= last && row[first] <= air) ++first;
        if (first > last) continue;
        while (last - first >= together && !any_above(row + last - together + 1, together, air))
          last -= together;
        while (last > first && row[last] <= air) --last;
        for (const auto i : {first, last}) {
          const Vector3d p = grid.point(i, j, k);
          by_slice[static_cast<std::size_t>(k)].add({p, p});
        }
      }
  });
  Box body;
  for (const auto& slice : by_slice) body.add(slice);
  if (body.low[0] > body.high[0]) body.low = body.high = 0.5 * (scan.low + scan.high);
  const Vector3d around = Vector3d::Constant(margin);
  const Vector3d low = (body.low - around).cwiseMax(scan.low),
                 high = (body.high + around).cwiseMin(scan.high);

  Grid out;
  out.axes = step * Eigen::Matrix3d::Identity();
  for (int c = 0; c < 3; ++c)
    out.size[static_cast<std::size_t>(c)] =
        static_cast<std::int64_t>(std::ceil((high[c] - low[c]) / step)) + 2;
  // centred, so that a mirrored scan gives the mirrored grid
  for (int c = 0; c < 3; ++c)
    out.origin[c] = 0.5 * (low[c] + high[c]) -
                    0.5 * step * static_cast<double>(out.size[static_cast<std::size_t>(c)] - 1);
  return out;
}

WorkVolume resampled(const GreyVolume& volume, double step, int threads) {
  return resampled(volume, work_grid(volume, step, threads), threads);
}

WorkVolume resampled(const GreyVolume& volume, const Grid& g, int threads) {
  const double step = g.axes(0, 0);
  WorkVolume out{{g, std::vector<std::int16_t>(g.count())}, {g, std::vector<std::uint8_t>(g.count(), 0)}};
  constexpr std::int16_t air = -1000;

  // samples over a box along the scan's own axes, as wide as a work voxel: as many as the scan has voxels in
  // it (1 to 4 per axis)
  const Eigen::Matrix3d to_index = volume.grid.axes.inverse();
  const Vector3d width = (step / volume.grid.spacing().array()).matrix();
  std::array<int, 3> n{};
  for (int c = 0; c < 3; ++c)
    n[static_cast<std::size_t>(c)] = std::clamp(static_cast<int>(std::lround(width[c])), 1, 4);
  const auto shift = [&](int c, int m) {
    return width[c] * ((m + 0.5) / n[static_cast<std::size_t>(c)] - 0.5);
  };
  std::vector<Vector3d> shifts;
  for (int c = 0; c < n[2]; ++c)
    for (int b = 0; b < n[1]; ++b)
      for (int a = 0; a < n[0]; ++a) shifts.emplace_back(shift(0, a), shift(1, b), shift(2, c));
  const auto index_at = [&](std::int64_t i, std::int64_t j, std::int64_t k) -> Vector3d {
    return to_index * (g.point(i, j, k) - volume.grid.origin);
  };
  const auto put = [&](std::size_t o, double mean) {
    out.hu.voxels[o] = static_cast<std::int16_t>(nearest_whole(hu_of(mean, volume.quantity)));
  };
  const auto put_samples = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const Vector3d index = index_at(i, j, k);
    double sum = 0;
    std::size_t held = 0;
    for (const auto& aside : shifts) {
      double value = 0;
      if (!sample(volume, index + aside, value)) continue;
      sum += value;
      ++held;
    }
    const std::size_t o = g.offset(i, j, k);
    out.seen.voxels[o] = 2 * held > shifts.size();
    if (held == 0)
      out.hu.voxels[o] = air;
    else
      put(o, sum / static_cast<double>(held));
  };
  if (!volume.grid.axes.isDiagonal(0)) {
    in_slabs(g.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
      for (std::int64_t k = k0; k < k1; ++k)
        for (std::int64_t j = 0; j < g.size[1]; ++j)
          for (std::int64_t i = 0; i < g.size[0]; ++i) put_samples(i, j, k);
    });
    return out;
  }
  // Aligned axes: the mean separates into means over slices, rows and voxels, except for work voxels at the
  // scan's borders and those that contain both padding and tissue.
  const auto windows_along = [&](int c) {
    const auto axis = static_cast<std::size_t>(c);
    Windows windows(static_cast<std::size_t>(g.size[axis]));
    std::vector<double> samples(static_cast<std::size_t>(n[axis]));
    for (std::int64_t m = 0; m < g.size[axis]; ++m) {
      for (int s = 0; s < n[axis]; ++s)
        samples[static_cast<std::size_t>(s)] =
            index_at(c == 0 ? m : 0, c == 1 ? m : 0, c == 2 ? m : 0)[c] + shift(c, s);
      windows.add(static_cast<std::size_t>(m), samples, volume.grid.size[axis]);
    }
    return windows;
  };
  const Windows x = windows_along(0), y = windows_along(1), z = windows_along(2);
  const int padding = padding_of(volume);
  const auto width_of_row = static_cast<std::size_t>(g.size[0]);
  const auto nx = static_cast<std::size_t>(volume.grid.size[0]),
             slice = nx * static_cast<std::size_t>(volume.grid.size[1]);
  // slices without padding need no extremes
  const std::vector<char> padded = padded_slices(volume, padding, threads);
  in_slabs(g.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    std::vector<double> of_slices(slice), of_rows(nx + x.weights.size()), means(width_of_row);
    Extremes slice_extremes(slice), row_extremes(nx + x.weights.size()), extremes(width_of_row);
    WeightedRows<std::int16_t> slices;
    WeightedRows<double> rows;
    for (std::int64_t k = k0; k < k1; ++k) {
      const auto kz = static_cast<std::size_t>(k);
      slices.clear();
      bool whole = true;  // no padding
      for (std::size_t c = 0; z.inside[kz] && c < z.weights.size(); ++c) {
        if (c > 0 && z.weights[c][kz] == 0) continue;
        slices.add(volume.voxels.data() + (z.first[kz] + c) * slice, z.weights[c][kz]);
        whole = whole && !padded[z.first[kz] + c];
      }
      sum_of(slices, slice, of_slices.data());
      for (std::size_t c = 0; !whole && c < slices.rows.size(); ++c)
        slice_extremes.add(c == 0, slice, slices.rows[c], slices.rows[c]);
      for (std::int64_t j = 0; j < g.size[1]; ++j) {
        const auto jy = static_cast<std::size_t>(j);
        const bool among = z.inside[kz] && y.inside[jy];
        rows.clear();
        for (std::size_t b = 0; among && b < y.weights.size(); ++b) {
          if (b > 0 && y.weights[b][jy] == 0) continue;
          const std::size_t row = (y.first[jy] + b) * nx;
          rows.add(of_slices.data() + row, y.weights[b][jy]);
          if (!whole) row_extremes.add(b == 0, nx, &slice_extremes.least[row], &slice_extremes.most[row]);
        }
        sum_of(rows, nx, of_rows.data());
        for (std::size_t i = 0; among && i < width_of_row; ++i) {
          const double* const from = of_rows.data() + x.first[i];
          double mean = 0;
          for (std::size_t a = 0; a < x.weights.size(); ++a) mean += x.weights[a][i] * from[a];
          means[i] = mean;
          for (std::size_t a = 0; !whole && a < x.weights.size(); ++a) {
            const std::int16_t low = row_extremes.least[x.first[i] + a],
                               high = row_extremes.most[x.first[i] + a];
            extremes.least[i] = a == 0 ? low : std::min(extremes.least[i], low);
            extremes.most[i] = a == 0 ? high : std::max(extremes.most[i], high);
          }
        }
        const std::size_t first = g.offset(0, j, k);
        for (std::size_t i = 0; i < width_of_row; ++i) {
          const bool inside = among && x.inside[i];
          if (inside && (whole || extremes.least[i] >= padding)) {
            out.seen.voxels[first + i] = 1;
            put(first + i, means[i]);
          } else if (inside && extremes.most[i] < padding) {
            out.hu.voxels[first + i] = air;
          } else {
            put_samples(static_cast<std::int64_t>(i), j, k);
          }
        }
      }
    }
  });
  return out;
}

}  // namespace borelli
