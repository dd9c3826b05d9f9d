#include "inertia/moments.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <thread>

// One portable build that still uses the machine's widest vectors: the loader picks the clone that it can
// run, and what is marked INLINE is compiled anew within each.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define BORELLI_VECTOR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BORELLI_VECTOR_CLONES
#endif
#define BORELLI_INLINE inline __attribute__((always_inline))

namespace borelli {
namespace {

// Eight voxels of a row side by side. Their alignment is said, since by itself it differs between the clones.
typedef double Lanes __attribute__((vector_size(64), aligned(64)));
typedef std::int64_t LaneMask __attribute__((vector_size(64), aligned(64)));

// The ten sums of one label. Voxel i of a row goes to lane (i - i0) % 8, i0 being where its run starts, and
// counts as if at i - lane: `moments` puts this right, once for all voxels of a lane.
struct Sums {
  std::int64_t voxels = 0;
  Lanes w{}, wi{}, wj{}, wk{}, wii{}, wjj{}, wkk{}, wij{}, wik{}, wjk{};

  Moments moments() const {
    Moments m;
    m.voxels = voxels;
    for (int lane = 0; lane < 8; ++lane) {
      const double di = lane, i = wi[lane] + di * w[lane];
      const double ii = wii[lane] + 2 * di * wi[lane] + di * di * w[lane];
      const double ij = wij[lane] + di * wj[lane], ik = wik[lane] + di * wk[lane];
      m.weight += w[lane];
      m.first += Eigen::Vector3d(i, wj[lane], wk[lane]);
      m.second(0, 0) += ii, m.second(1, 1) += wjj[lane], m.second(2, 2) += wkk[lane];
      m.second(1, 0) += ij, m.second(2, 0) += ik, m.second(2, 1) += wjk[lane];
    }
    m.second = m.second.selfadjointView<Eigen::Lower>();
    return m;
  }
};

// Sums along one run: of w, w b and w b^2, voxel n of the run being in block b = n / 8, lane n % 8.
struct RunSums {
  Lanes w, wb, wbb;
};

// `weights` points at the weight of grey value 0. Up to seven voxels behind the run are read, and weigh
// nothing.
BORELLI_INLINE void sum_run(const std::int16_t* grey, std::int64_t count, const double* weights,
                            RunSums& sums) {
  Lanes w{}, wb{}, wbb{};
  const auto add = [&](std::int64_t block, const LaneMask& mask) __attribute__((always_inline)) {
    const std::int16_t* g = grey + 8 * block;
    Lanes v = {weights[g[0]], weights[g[1]], weights[g[2]], weights[g[3]],
               weights[g[4]], weights[g[5]], weights[g[6]], weights[g[7]]};
    v = reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(v) & mask);
    const double b = static_cast<double>(block);
    w += v;
    wb += b * v;
    wbb += b * b * v;
  };
  const LaneMask lane = {0, 1, 2, 3, 4, 5, 6, 7}, all = lane >= 0;
  const std::int64_t blocks = count / 8;
  for (std::int64_t block = 0; block < blocks; ++block) add(block, all);
  if (count > 8 * blocks) add(blocks, lane < count - 8 * blocks);
  sums = {w, wb, wbb};
}

// The same with w = 1: sums of whole numbers, all put into lane 0, whose voxels n count as if in block n / 8.
BORELLI_INLINE void sum_run(std::int64_t count, RunSums& sums) {
  const double n = static_cast<double>(count);
  sums = {Lanes{n}, Lanes{n * (n - 1) / 2 / 8}, Lanes{n * (n - 1) * (2 * n - 1) / 6 / 64}};
}

// Number of voxels from `label` on, up to `end`, that hold *label.
BORELLI_INLINE std::int64_t run_length(const std::uint8_t* label, const std::uint8_t* end) {
  constexpr std::int64_t block = 64;
  const std::uint8_t value = *label;
  const std::uint8_t* p = label;
  for (; end - p >= block; p += block) {
    std::uint8_t differs = 0;
    for (std::int64_t n = 0; n < block; ++n) differs |= static_cast<std::uint8_t>(p[n] ^ value);
    if (differs) break;
  }
  const std::uint64_t pattern = 0x0101010101010101u * value;
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

BORELLI_INLINE void add_run(Sums& sums, std::int64_t count, const RunSums& run, double i, double j,
                            double k) {
  const Lanes w = run.w, wi = 8 * run.wb + i * w;
  sums.voxels += count;
  sums.w += w, sums.wi += wi, sums.wj += j * w, sums.wk += k * w;
  sums.wii += 64 * run.wbb + 16 * i * run.wb + i * i * w, sums.wjj += j * j * w, sums.wkk += k * k * w;
  sums.wij += j * wi, sums.wik += k * wi, sums.wjk += j * k * w;
}

// A slab of a volume: slices [first, last). Without `grey` each voxel weighs 1.
struct Slab {
  const std::uint8_t* labels;  // of the whole volume, as is
  const std::int16_t* grey;
  const double* weights;  // of grey value 0
  std::array<std::int64_t, 3> size;
  std::int64_t first, last;
};

BORELLI_VECTOR_CLONES
void sum_slab(const Slab& slab, std::array<Sums, 256>& sums) {
  const auto [nx, ny, nz] = slab.size;
  const std::int64_t count = nx * ny * nz;
  for (std::int64_t k = slab.first; k < slab.last; ++k)
    for (std::int64_t j = 0; j < ny; ++j) {
      const std::int64_t row = (k * ny + j) * nx;
      const std::uint8_t* const end = slab.labels + row + nx;
      for (std::int64_t i = 0, length; i < nx; i += length) {
        const std::uint8_t* const label = slab.labels + row + i;
        length = run_length(label, end);
        if (*label == 0) continue;
        RunSums run;
        if (!slab.grey) {
          sum_run(length, run);
        } else if (row + i + length + 7 < count) {
          sum_run(slab.grey + row + i, length, slab.weights, run);
        } else {  // nothing may be read behind the volume's end
          std::vector<std::int16_t> padded(slab.grey + row + i, slab.grey + row + i + length);
          padded.resize(padded.size() + 8);
          sum_run(padded.data(), length, slab.weights, run);
        }
        add_run(sums[*label], length, run, static_cast<double>(i), static_cast<double>(j),
                static_cast<double>(k));
      }
    }
}

// Slabs of fixed thickness, each summed by whichever thread comes by, and added up in their order: so the
// sums do not depend on the number of threads.
LabelMoments sum_volume(const LabelMap& labels, const std::int16_t* grey, const double* weights,
                        int threads) {
  const std::int64_t slices = labels.grid.size[2], thickness = 8;
  const std::int64_t slabs = (slices + thickness - 1) / thickness;
  std::vector<LabelMoments> slab_moments(static_cast<std::size_t>(slabs));
  std::atomic<std::int64_t> next{0};
  const auto work = [&] {
    std::vector<std::array<Sums, 256>> sums(1);
    for (std::int64_t slab; (slab = next++) < slabs;) {
      sums[0].fill({});
      const std::int64_t first = slab * thickness, last = std::min(slices, first + thickness);
      sum_slab({labels.voxels.data(), grey, weights, labels.grid.size, first, last}, sums[0]);
      for (std::size_t label = 1; label < 256; ++label)
        if (sums[0][label].voxels > 0)
          slab_moments[static_cast<std::size_t>(slab)][label] = sums[0][label].moments();
    }
  };
  const int wanted = threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency());
  {
    std::vector<std::jthread> others;
    for (std::int64_t t = 1; t < std::min<std::int64_t>(wanted, slabs); ++t) others.emplace_back(work);
    work();
  }
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
    return failure("moments", "the labels or the volume hold fewer or more voxels than their grid has");
  if (weights.size() != 65536)
    return failure("moments", fmt::format("{} weights given, one for each of the 65536 grey values expected",
                                          weights.size()));
  return {};
}

Result<LabelMoments> label_moments(const LabelMap& labels, const Volume<std::int16_t>& grey,
                                   const GreyWeights& weights, int threads) {
  if (auto checked = check_same_grid(labels, grey, weights); !checked) return tl::unexpected(checked.error());
  return sum_volume(labels, grey.voxels.data(), weights.data() + 32768, threads);
}

Result<LabelMoments> label_moments(const LabelMap& labels, int threads) {
  if (!is_whole(labels))
    return failure("moments", "the labels hold fewer or more voxels than their grid has");
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
