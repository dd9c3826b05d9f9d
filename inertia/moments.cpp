#include "inertia/moments.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>

#include "threads/clones.hpp"
#include "threads/slabs.hpp"

// (Registers wider than the clones' gain nothing: looking up weights takes most of the time.) Functions
// marked INLINE are compiled within each clone.
#define BORELLI_INLINE inline __attribute__((always_inline))

namespace borelli {
namespace {

// Eight voxels of a row in two halves: a vector of eight would go through memory on machines with registers
// of four. The alignment is explicit, since the default differs between clones.
typedef double Half __attribute__((vector_size(32), aligned(32)));
typedef std::int64_t HalfMask __attribute__((vector_size(32), aligned(32)));
struct Lanes {
  Half low{}, high{};

  double operator[](int lane) const { return lane < 4 ? low[lane] : high[lane - 4]; }
  BORELLI_INLINE Lanes& operator+=(const Lanes& b) { return low += b.low, high += b.high, *this; }
  friend BORELLI_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
    return {a.low - b.low, a.high - b.high};
  }
  friend BORELLI_INLINE Lanes operator*(double a, const Lanes& b) { return {a * b.low, a * b.high}; }
};

// The sums of one label in one slice, along a row in blocks of eight voxels, i = 8 b. Voxel i of a row goes
// to lane (i - i0) % 8, where i0 is the start of its run, and is summed as if at i - lane. `moments` corrects
// this once for all voxels of a lane.
struct SliceSums {
  std::int64_t voxels = 0;
  Lanes w{}, wb{}, wj{}, wbb{}, wbj{}, wjj{};

  // Moments of slice k.
  Moments moments(double k) const {
    Moments m;
    m.voxels = voxels;
    for (int lane = 0; lane < 8; ++lane) {
      const double di = lane, wi = 8 * wb[lane] + di * w[lane];
      m.weight += w[lane];
      m.first[0] += wi, m.first[1] += wj[lane];
      m.second(0, 0) += 64 * wbb[lane] + 16 * di * wb[lane] + di * di * w[lane];
      m.second(1, 0) += 8 * wbj[lane] + di * wj[lane], m.second(1, 1) += wjj[lane];
    }
    m.first[2] = k * m.weight;
    m.second.row(2) = k * m.first.transpose();
    m.second = m.second.selfadjointView<Eigen::Lower>();
    return m;
  }
};

// Sums along one run of `blocks` blocks (voxels of weight 1 may end in a partial block). With n counting
// blocks from the last (n = 1) to the first (n = blocks): sums of w, of n w, and of n (n + 1) / 2 w.
struct RunSums {
  Lanes once, twice, thrice;
  double blocks;
};

// `weights` points at the weight of grey value 0. Up to seven voxels behind the run are read, with weight 0.
BORELLI_INLINE void sum_run(const std::int16_t* grey, std::int64_t count, const double* weights,
                            RunSums& sums) {
  constexpr std::int64_t ahead = 1024;  // voxels
  Lanes once{}, twice{}, thrice{};
  const auto add = [&](const std::int16_t* block, const HalfMask& low, const HalfMask& high)
      __attribute__((always_inline)) {
    // load four voxels at once: the number of loads per cycle is the bottleneck
    std::uint64_t four;
    std::memcpy(&four, block, sizeof four);
    const auto g = [&](int n) __attribute__((always_inline)) {
      if (n >= 4) return block[n];
      const int place = std::endian::native == std::endian::little ? n : 3 - n;
      return static_cast<std::int16_t>(std::rotr(four, 16 * place));
    };
    const Half a = {weights[g(0)], weights[g(1)], weights[g(2)], weights[g(3)]};
    const Half b = {weights[g(4)], weights[g(5)], weights[g(6)], weights[g(7)]};
    once += Lanes{reinterpret_cast<Half>(reinterpret_cast<HalfMask>(a) & low),
                  reinterpret_cast<Half>(reinterpret_cast<HalfMask>(b) & high)};
    twice += once;
    thrice += twice;
  };
  const HalfMask low = {0, 1, 2, 3}, high = {4, 5, 6, 7}, all = low >= 0;
  // (the hardware prefetcher loses track of grey values across empty runs)
  const auto address = reinterpret_cast<std::uintptr_t>(grey);
  for (std::int64_t n = 0; n < count; n += 32)
    __builtin_prefetch(
        reinterpret_cast<const void*>(address + sizeof *grey * static_cast<std::size_t>(n + ahead)));
  const std::int64_t left = count & 7;
  const std::int16_t* const end = grey + (count - left);
  for (const std::int16_t* block = grey; block != end; block += 8) add(block, all, all);
  if (left > 0) add(end, low < left, high < left);
  sums = {once, twice, thrice, static_cast<double>((count + 7) >> 3)};
}

// The same with w = 1: sums of integers, all in lane 0; voxel n counts as n / 8 blocks.
BORELLI_INLINE void sum_run(std::int64_t count, RunSums& sums) {
  const double n = static_cast<double>(count), twice = n * (n + 1) / 2 / 8;
  const double squares = n * (n + 1) * (2 * n + 1) / 6 / 64;
  sums = {{Half{n}}, {Half{twice}}, {Half{(squares + twice) / 2}}, n / 8};
}

// Number of consecutive voxels equal to *label, from `label` up to `end`.
BORELLI_INLINE std::int64_t run_length(const std::uint8_t* label, const std::uint8_t* end) {
  typedef std::uint64_t Words __attribute__((vector_size(32)));
  const std::uint8_t value = *label;
  const std::uint64_t pattern = 0x0101010101010101u * value;
  const std::uint8_t* p = label;
  for (; end - p >= 64; p += 64) {
    Words low, high;
    std::memcpy(&low, p, 32);
    std::memcpy(&high, p + 32, 32);
    const Words differs = (low ^ pattern) | (high ^ pattern);
    if ((differs[0] | differs[1] | differs[2] | differs[3]) != 0) break;
  }
  for (std::uint64_t word; end - p >= 8; p += 8) {
    std::memcpy(&word, p, 8);
    if (word ^= pattern; word != 0) {
      const bool little = std::endian::native == std::endian::little;
      return p - label + (little ? std::countr_zero(word) : std::countl_zero(word)) / 8;
    }
  }
  while (p < end && *p == value) ++p;
  return p - label;
}

// Adds a run that begins at voxel i of row j.
BORELLI_INLINE void add_run(SliceSums& sums, std::int64_t count, const RunSums& run, double i, double j) {
  const double end = i / 8 + run.blocks;  // from which on the run's blocks were counted back
  const Lanes wb = end * run.once - run.twice;
  sums.voxels += count;
  sums.w += run.once, sums.wb += wb, sums.wj += j * run.once;
  sums.wbb += end * (wb - run.twice), sums.wbb += 2 * run.thrice - run.twice;
  sums.wbj += j * wb, sums.wjj += j * j * run.once;
}

// A slab of a volume: slices [first, last). Without `grey` each voxel weighs 1.
struct Slab {
  const std::uint8_t* labels;  // of the whole volume
  const std::int16_t* grey;
  const double* weights;  // address of the weight of grey value 0
  std::array<std::int64_t, 3> size;
  std::int64_t first, last;
};

// For a run at the volume's end, behind which nothing may be read.
__attribute__((noinline, cold)) void sum_last_run(const std::int16_t* grey, std::int64_t count,
                                                  const double* weights, RunSums& run) {
  std::vector<std::int16_t> padded(grey, grey + count);
  padded.resize(padded.size() + 8);
  sum_run(padded.data(), count, weights, run);
}

BORELLI_VECTOR_CLONES
void sum_slab(const Slab& slab, std::array<SliceSums, 256>& sums, LabelMoments& moments) {
  const auto [nx, ny, nz] = slab.size;
  const std::uint8_t* const labels_end = slab.labels + nx * ny * nz;
  for (std::int64_t k = slab.first; k < slab.last; ++k) {
    for (std::int64_t j = 0; j < ny; ++j) {
      const std::uint8_t* const row = slab.labels + (k * ny + j) * nx;
      for (const std::uint8_t *label = row, *end = row; label < row + nx; label = end) {
        const std::int64_t length = run_length(label, row + nx);
        end = label + length;
        if (*label == 0) continue;
        RunSums run;
        if (!slab.grey)
          sum_run(length, run);
        else if (labels_end - end > 7)
          sum_run(slab.grey + (label - slab.labels), length, slab.weights, run);
        else
          sum_last_run(slab.grey + (label - slab.labels), length, slab.weights, run);
        add_run(sums[*label], length, run, static_cast<double>(label - row), static_cast<double>(j));
      }
    }
    for (std::size_t label = 1; label < 256; ++label)
      if (sums[label].voxels > 0) {
        moments[label] += sums[label].moments(static_cast<double>(k));
        sums[label] = {};
      }
  }
}

// Slabs of fixed thickness, summed by any thread and added in order, so that the sums do not depend on the
// number of threads.
LabelMoments sum_volume(const LabelMap& labels, const std::int16_t* grey, const double* weights,
                        int threads) {
  const std::int64_t slices = labels.grid.size[2], thickness = 8;
  const std::int64_t slabs = (slices + thickness - 1) / thickness;
  std::vector<LabelMoments> slab_moments(static_cast<std::size_t>(slabs));
  std::atomic<std::int64_t> next{0};
  const auto work = [&] {
    std::vector<std::array<SliceSums, 256>> sums(1);  // all zero, the state in which each slice leaves them
    for (std::int64_t slab; (slab = next++) < slabs;) {
      const std::int64_t first = slab * thickness, last = std::min(slices, first + thickness);
      sum_slab({labels.voxels.data(), grey, weights, labels.grid.size, first, last}, sums[0],
               slab_moments[static_cast<std::size_t>(slab)]);
    }
  };
  in_slabs(slabs, threads, [&](std::int64_t, std::int64_t) { work(); });
  LabelMoments total;
  for (const auto& slab : slab_moments)
    for (std::size_t label = 1; label < 256; ++label)
      if (slab[label].voxels > 0) total[label] += slab[label];
  return total;
}

template <class T>
bool is_whole(const Volume<T>& volume) {
  return volume.voxels.size() == volume.grid.count();
}

}  // namespace

Moments& Moments::operator+=(const Moments& other) {
  voxels += other.voxels;
  weight += other.weight;
  first += other.first;
  second += other.second;
  return *this;
}

Result<void> check_same_grid(const LabelMap& labels, const Volume<std::int16_t>& grey,
                             const GreyWeights& weights) {
  if (!(labels.grid == grey.grid))
    return failure("moments",
                   fmt::format("labels and volume must share one grid, but the labels have {} x {} x {} "
                               "voxels and the volume {} x {} x {}, or their axes or origins differ",
                               labels.grid.size[0], labels.grid.size[1], labels.grid.size[2],
                               grey.grid.size[0], grey.grid.size[1], grey.grid.size[2]));
  if (!is_whole(labels) || !is_whole(grey))
    return failure("moments", "the number of voxels of the labels or of the volume is not that of its grid");
  if (weights.size() != 65536)
    return failure(
        "moments",
        fmt::format("{} weights were given, expected one for each of the 65536 grey values", weights.size()));
  return {};
}

Result<LabelMoments> label_moments(const LabelMap& labels, const Volume<std::int16_t>& grey,
                                   const GreyWeights& weights, int threads) {
  if (auto checked = check_same_grid(labels, grey, weights); !checked) return tl::unexpected(checked.error());
  return sum_volume(labels, grey.voxels.data(), weights.data() + 32768, threads);
}

Result<LabelMoments> label_moments(const LabelMap& labels, int threads) {
  if (!is_whole(labels))
    return failure("moments", "the number of voxels of the labels is not that of their grid");
  return sum_volume(labels, nullptr, nullptr, threads);
}

Inertial to_inertial(const Moments& moments, const Grid& grid, Sampling sampling) {
  if (moments.weight == 0) return {};
  constexpr double mm = 1e-3;
  const double mass = moments.weight * grid.voxel_volume() * mm * mm * mm;
  const Eigen::Vector3d mean = moments.first / moments.weight;
  Eigen::Matrix3d covariance = moments.second / moments.weight - mean * mean.transpose();
  if (sampling == Sampling::averages) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> extent(covariance, Eigen::EigenvaluesOnly);
    if (extent.eigenvalues()[0] >= 0.25) covariance.diagonal().array() -= 1. / 12;
  }
  const Eigen::Matrix3d axes = mm * grid.axes;
  const Eigen::Matrix3d second = mass * axes * covariance * axes.transpose();
  return {mass, mm * grid.point(mean), second.trace() * Eigen::Matrix3d::Identity() - second};
}

}  // namespace borelli
