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

// Writes the mean of trilinear samples over each work voxel: over a box along the scan's own axes, as wide as
// the work voxel, with as many samples as the scan has voxels in it (1 to 4 per axis).
class BoxMeans {
 public:
  BoxMeans(const GreyVolume& scan, WorkVolume& out)
      : scan_(scan),
        grid_(out.hu.grid),
        out_(out),
        to_index_(scan.grid.axes.inverse()),
        width_((grid_.axes(0, 0) / scan.grid.spacing().array()).matrix()) {
    for (int c = 0; c < 3; ++c)
      samples_[static_cast<std::size_t>(c)] = std::clamp(static_cast<int>(std::lround(width_[c])), 1, 4);
    for (int c = 0; c < samples_[2]; ++c)
      for (int b = 0; b < samples_[1]; ++b)
        for (int a = 0; a < samples_[0]; ++a) shifts_.emplace_back(shift(0, a), shift(1, b), shift(2, c));
  }

  // The scan's voxels whose means these are along one axis, if the scan's axes are those of the work grid.
  Windows windows_along(int c) const {
    const auto axis = static_cast<std::size_t>(c);
    Windows windows(static_cast<std::size_t>(grid_.size[axis]));
    std::vector<double> samples(static_cast<std::size_t>(samples_[axis]));
    for (std::int64_t m = 0; m < grid_.size[axis]; ++m) {
      for (int s = 0; s < samples_[axis]; ++s)
        samples[static_cast<std::size_t>(s)] =
            index_at(c == 0 ? m : 0, c == 1 ? m : 0, c == 2 ? m : 0)[c] + shift(c, s);
      windows.add(static_cast<std::size_t>(m), samples, scan_.grid.size[axis]);
    }
    return windows;
  }

  // A work voxel without padding.
  void put_seen(std::size_t offset, double mean) {
    out_.seen.voxels[offset] = 1;
    put(offset, mean);
  }
  // A work voxel of padding alone.
  void put_unseen(std::size_t offset) { out_.hu.voxels[offset] = air; }
  // Any work voxel: takes the samples that the scan shows.
  void put_samples(std::int64_t i, std::int64_t j, std::int64_t k) {
    const Vector3d index = index_at(i, j, k);
    double sum = 0;
    std::size_t held = 0;
    for (const auto& aside : shifts_) {
      double value = 0;
      if (!sample(scan_, index + aside, value)) continue;
      sum += value;
      ++held;
    }
    const std::size_t offset = grid_.offset(i, j, k);
    out_.seen.voxels[offset] = 2 * held > shifts_.size();
    if (held == 0)
      put_unseen(offset);
    else
      put(offset, sum / static_cast<double>(held));
  }

 private:
  static constexpr std::int16_t air = -1000;

  void put(std::size_t offset, double mean) {
    out_.hu.voxels[offset] = static_cast<std::int16_t>(nearest_whole(hu_of(mean, scan_.quantity)));
  }
  // of sample m along axis c from the work voxel's centre, in scan voxels
  double shift(int c, int m) const {
    return width_[c] * ((m + 0.5) / samples_[static_cast<std::size_t>(c)] - 0.5);
  }
  Vector3d index_at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return to_index_ * (grid_.point(i, j, k) - scan_.grid.origin);
  }

  const GreyVolume& scan_;
  const Grid& grid_;
  WorkVolume& out_;
  Eigen::Matrix3d to_index_;
  Vector3d width_;  // of a work voxel, in scan voxels
  std::array<int, 3> samples_{};
  std::vector<Vector3d> shifts_;
};

void put_sampled_means(BoxMeans& means, const Grid& grid, int threads) {
  in_slabs(grid.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < grid.size[1]; ++j)
        for (std::int64_t i = 0; i < grid.size[0]; ++i) means.put_samples(i, j, k);
  });
}

// A scan whose axes are those of the work grid, with the windows along them.
struct AlignedScan {
  const GreyVolume& volume;
  int padding;
  Windows x, y, z;
  std::vector<char> padded;  // see padded_slices

  std::size_t row() const { return static_cast<std::size_t>(volume.grid.size[0]); }
  std::size_t slice() const { return row() * static_cast<std::size_t>(volume.grid.size[1]); }
};

// The means of one work row after the other: over the scan's slices, then its rows, then its voxels. Slices
// without padding need no extremes.
class SeparateMeans {
 public:
  enum class Content {
    seen,
    padding,
    other  // at the scan's border, or both padding and tissue
  };

  explicit SeparateMeans(const AlignedScan& scan)
      : scan_(scan),
        of_slices_(scan.slice()),
        of_rows_(scan.row() + scan.x.weights.size()),
        means_(scan.x.first.size()),
        slice_extremes_(of_slices_.size()),
        row_extremes_(of_rows_.size()),
        extremes_(means_.size()) {}

  void go_to_slice(std::size_t k) {
    const Windows& z = scan_.z;
    slices_.clear();
    whole_ = true;
    slice_inside_ = z.inside[k];
    for (std::size_t c = 0; slice_inside_ && c < z.weights.size(); ++c) {
      if (c > 0 && z.weights[c][k] == 0) continue;
      slices_.add(scan_.volume.voxels.data() + (z.first[k] + c) * scan_.slice(), z.weights[c][k]);
      whole_ = whole_ && !scan_.padded[z.first[k] + c];
    }
    sum_of(slices_, scan_.slice(), of_slices_.data());
    for (std::size_t c = 0; !whole_ && c < slices_.rows.size(); ++c)
      slice_extremes_.add(c == 0, scan_.slice(), slices_.rows[c], slices_.rows[c]);
  }

  void go_to_row(std::size_t j) {
    const Windows& y = scan_.y;
    inside_ = slice_inside_ && y.inside[j];
    if (!inside_) return;
    const std::size_t nx = scan_.row();
    rows_.clear();
    for (std::size_t b = 0; b < y.weights.size(); ++b) {
      if (b > 0 && y.weights[b][j] == 0) continue;
      const std::size_t row = (y.first[j] + b) * nx;
      rows_.add(of_slices_.data() + row, y.weights[b][j]);
      if (!whole_) row_extremes_.add(b == 0, nx, &slice_extremes_.least[row], &slice_extremes_.most[row]);
    }
    sum_of(rows_, nx, of_rows_.data());
    find_means();
    if (!whole_) find_extremes();
  }

  Content content(std::size_t i) const {
    if (!inside_ || !scan_.x.inside[i]) return Content::other;
    if (whole_ || extremes_.least[i] >= scan_.padding) return Content::seen;
    return extremes_.most[i] < scan_.padding ? Content::padding : Content::other;
  }
  double mean(std::size_t i) const { return means_[i]; }

 private:
  void find_means() {
    const Windows& x = scan_.x;
    for (std::size_t i = 0; i < means_.size(); ++i) {
      const double* const from = of_rows_.data() + x.first[i];
      double mean = 0;
      for (std::size_t a = 0; a < x.weights.size(); ++a) mean += x.weights[a][i] * from[a];
      means_[i] = mean;
    }
  }
  void find_extremes() {
    const Windows& x = scan_.x;
    for (std::size_t i = 0; i < means_.size(); ++i)
      for (std::size_t a = 0; a < x.weights.size(); ++a) {
        const std::int16_t low = row_extremes_.least[x.first[i] + a],
                           high = row_extremes_.most[x.first[i] + a];
        extremes_.least[i] = a == 0 ? low : std::min(extremes_.least[i], low);
        extremes_.most[i] = a == 0 ? high : std::max(extremes_.most[i], high);
      }
  }

  const AlignedScan& scan_;
  std::vector<double> of_slices_, of_rows_, means_;
  Extremes slice_extremes_, row_extremes_, extremes_;
  WeightedRows<std::int16_t> slices_;
  WeightedRows<double> rows_;
  bool whole_ = true;                           // no padding in the slices
  bool slice_inside_ = false, inside_ = false;  // all of the slice's, the row's samples lie in the scan
};

// Aligned axes: the mean separates into means over slices, rows and voxels, except for work voxels at the
// scan's borders and those that contain both padding and tissue.
void put_separate_means(const GreyVolume& volume, BoxMeans& means, const Grid& grid, int threads) {
  const int padding = padding_of(volume);
  const AlignedScan scan{volume,
                         padding,
                         means.windows_along(0),
                         means.windows_along(1),
                         means.windows_along(2),
                         padded_slices(volume, padding, threads)};
  in_slabs(grid.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    SeparateMeans separate(scan);
    for (std::int64_t k = k0; k < k1; ++k) {
      separate.go_to_slice(static_cast<std::size_t>(k));
      for (std::int64_t j = 0; j < grid.size[1]; ++j) {
        separate.go_to_row(static_cast<std::size_t>(j));
        const std::size_t first = grid.offset(0, j, k);
        for (std::size_t i = 0; i < static_cast<std::size_t>(grid.size[0]); ++i)
          switch (separate.content(i)) {
            case SeparateMeans::Content::seen:
              means.put_seen(first + i, separate.mean(i));
              break;
            case SeparateMeans::Content::padding:
              means.put_unseen(first + i);
              break;
            case SeparateMeans::Content::other:
              means.put_samples(static_cast<std::int64_t>(i), j, k);
          }
      }
    }
  });
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

WorkVolume resampled(const GreyVolume& volume, const Grid& grid, int threads) {
  WorkVolume out{{grid, std::vector<std::int16_t>(grid.count())},
                 {grid, std::vector<std::uint8_t>(grid.count(), 0)}};
  BoxMeans means(volume, out);
  if (volume.grid.axes.isDiagonal(0))
    put_separate_means(volume, means, grid, threads);
  else
    put_sampled_means(means, grid, threads);
  return out;
}

}  // namespace borelli
