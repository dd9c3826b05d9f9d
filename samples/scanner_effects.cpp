#include "samples/scanner_effects.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "samples/phantom_builder.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

std::int16_t to_hu(double value) {
  return static_cast<std::int16_t>(std::lround(std::clamp(value, -1024.0, 3071.0)));
}

// splitmix64 (Steele, Lea & Flood 2014): one number per counter, independent of the order of calls
std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

// A standard normal number per voxel (Box & Muller 1958).
double normal_at(std::uint64_t seed, std::uint64_t voxel) {
  const std::uint64_t one = mixed(mixed(seed) ^ (2 * voxel)), two = mixed(mixed(seed) ^ (2 * voxel + 1));
  const double u = (static_cast<double>(one >> 11) + 0.5) * 0x1p-53,
               v = static_cast<double>(two >> 11) * 0x1p-53;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

// Blurs along one axis of the grid, with air beyond the grid.
void blur_axis(std::vector<float>& voxels, const Grid& grid, int axis, double sigma, int threads) {
  const double step = grid.axes.col(axis).norm(), s = sigma / step;
  const int reach = static_cast<int>(std::ceil(4 * s));
  std::vector<double> weight(static_cast<std::size_t>(2 * reach + 1));
  double sum = 0;
  for (int t = -reach; t <= reach; ++t)
    sum += weight[static_cast<std::size_t>(t + reach)] = std::exp(-0.5 * t * t / (s * s));
  for (double& w : weight) w /= sum;
  const std::size_t u = static_cast<std::size_t>(axis);
  const std::int64_t n = grid.size[u], other = axis == 2 ? grid.size[1] : grid.size[2];
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? grid.size[0] : grid.size[0] * grid.size[1];
  each_slice(other, threads, [&](std::int64_t m) {
    std::vector<double> line(static_cast<std::size_t>(n + 2 * reach), -1000.0);
    const std::int64_t lines = axis == 0 ? grid.size[1] : grid.size[0];
    for (std::int64_t l = 0; l < lines; ++l) {
      const std::size_t begin = axis == 0   ? grid.offset(0, l, m)
                                : axis == 1 ? grid.offset(l, 0, m)
                                            : grid.offset(l, m, 0);
      for (std::int64_t i = 0; i < n; ++i)
        line[static_cast<std::size_t>(i + reach)] = voxels[begin + static_cast<std::size_t>(i * stride)];
      for (std::int64_t i = 0; i < n; ++i) {
        double value = 0;
        for (std::size_t t = 0; t < weight.size(); ++t)
          value += weight[t] * line[static_cast<std::size_t>(i) + t];
        voxels[begin + static_cast<std::size_t>(i * stride)] = static_cast<float>(value);
      }
    }
  });
}

// Adds streaks to slices with metal: dark along its long side, alternately bright and dark in between, weaker
// with distance. They imitate beam hardening and photon starvation, without modelling them.
void add_streaks(std::vector<float>& value, const GreyVolume& grey, const ScanOptions& options) {
  const Grid& grid = grey.grid;
  const double side = 20;  // mm, from the metal's middle
  each_slice(grid.size[2], options.threads, [&](std::int64_t k) {
    Vector3d sum = Vector3d::Zero();
    double count = 0;
    const auto visit = [&](const auto& each) {
      for (std::int64_t j = 0; j < grid.size[1]; ++j)
        for (std::int64_t i = 0; i < grid.size[0]; ++i)
          each(grid.offset(i, j, k), Vector3d(double(i), double(j), double(k)));
    };
    visit([&](std::size_t o, const Vector3d& at) {
      if (grey.voxels[o] == tissue::metal.hu) sum += at, ++count;
    });
    if (count == 0) return;
    const Vector3d middle = grid.point(sum / count);
    const double turn =
        static_cast<double>(k) * grid.axes.col(2).norm() / 15;  // the streaks rotate from slice to slice
    visit([&](std::size_t o, const Vector3d& at) {
      if (grey.voxels[o] == tissue::metal.hu) return;
      const Vector3d d = grid.point(at) - middle;
      const double r = d.norm(), angle = std::atan2(d.y(), d.x());
      const double ray = 0.6 * std::cos(2 * angle + std::numbers::pi) + 0.4 * std::cos(13 * angle + turn);
      value[o] += static_cast<float>(options.streaks_hu * ray * std::pow(side / std::max(r, side), 1.3));
    });
  });
}

}  // namespace

void limit_view(Scan& scan, double diameter, int threads) {
  if (diameter <= 0) return;
  const Grid& grid = scan.grey.grid;
  const Vector3d middle(0.5 * static_cast<double>(grid.size[0] - 1),
                        0.5 * static_cast<double>(grid.size[1] - 1), 0);
  each_slice(grid.size[2], threads, [&](std::int64_t k) {
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i) {
        const Vector3d off = Vector3d(double(i), double(j), 0) - middle;
        if ((grid.axes * off).norm() <= 0.5 * diameter) continue;
        scan.grey.at(i, j, k) = -2000;
        scan.labels.at(i, j, k) = 0;
      }
  });
}

void add_scanner_effects(std::vector<float> value, const ScanOptions& options, Scan& scan) {
  const Grid& grid = scan.grey.grid;
  const auto plane = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
  if (options.streaks_hu > 0) add_streaks(value, scan.grey, options);
  if (options.blur_mm > 0)
    for (int axis = 0; axis < 3; ++axis) blur_axis(value, grid, axis, options.blur_mm, options.threads);
  each_slice(grid.size[2], options.threads, [&](std::int64_t k) {
    const std::size_t begin = static_cast<std::size_t>(k) * plane;
    for (std::size_t v = begin; v < begin + plane; ++v) {
      const double noise = options.noise_hu > 0 ? options.noise_hu * normal_at(options.seed, v) : 0;
      scan.grey.voxels[v] = to_hu(value[v] + noise);
    }
  });
  limit_view(scan, options.field_of_view, options.threads);
}

}  // namespace borelli
