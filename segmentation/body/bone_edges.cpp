#include "segmentation/body/bone_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "segmentation/grid/work_grid.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// a smaller fall may be noise or marrow, CT numbers
constexpr double least_fall = 100;
// CT numbers are clamped to this range: below it, fat against muscle is no bone edge; above it lie cortex and
// metal
constexpr double lowest = 20, highest = 1500;
// lower values come from voxels out of view, or from interpolation with them
constexpr double unseen = -1100;
// along one ray: more than 100 mm at the finest step
constexpr std::size_t most_samples = 512;

}  // namespace

double CloseUp::at(const Vector3d& point) const {
  double value = 0;
  along(point, Vector3d::Zero(), 1, &value);
  return value;
}

void CloseUp::along(const Vector3d& from, const Vector3d& step, int count, double* values) const {
  const auto& g = hu.grid;
  const double scale = 1 / g.axes(0, 0);
  const Vector3d start = (from - g.origin) * scale, stride = step * scale;
  const auto sy = g.size[0], sz = g.size[0] * g.size[1];
  const Vector3d end(static_cast<double>(g.size[0] - 1), static_cast<double>(g.size[1] - 1),
                     static_cast<double>(g.size[2] - 1));
  const auto inside = [&](int n) {
    const Vector3d at = start + n * stride;
    return (at.array() >= 0).all() && (at.array() < end.array()).all();
  };
  const double row = static_cast<double>(sy), slice = static_cast<double>(sz);
  // offset: the voxel below a point; tx, ty, tz: the point's fractions. Integers are kept as doubles, which
  // vectorise.
  constexpr int together = 64;
  std::array<std::int32_t, together> offset;
  std::array<double, together> tx, ty, tz;
  const auto fill = [&](int first, int length) {
    for (int m = 0; m < length; ++m) {
      const int n = first + m;
      const double x = start[0] + n * stride[0], y = start[1] + n * stride[1], z = start[2] + n * stride[2];
      const double i = static_cast<std::int32_t>(x), j = static_cast<std::int32_t>(y),
                   k = static_cast<std::int32_t>(z);
      offset[m] = static_cast<std::int32_t>(k * slice + j * row + i);
      tx[m] = x - i, ty[m] = y - j, tz[m] = z - k;
    }
    for (int m = 0; m < length; ++m) {
      const double* const p = hu.voxels.data() + offset[m];
      const auto line = [&](const double* q) { return q[0] + tx[m] * (q[1] - q[0]); };
      const double low = line(p) + ty[m] * (line(p + sy) - line(p));
      const double high = line(p + sz) + ty[m] * (line(p + sz + sy) - line(p + sz));
      values[first + m] = low + tz[m] * (high - low);
    }
  };
  if (count > 0 && inside(0) && inside(count - 1))  // then all points are inside
    for (int n = 0; n < count; n += together) fill(n, std::min(together, count - n));
  else
    for (int n = 0; n < count; ++n)
      if (inside(n))
        fill(n, 1);
      else
        values[n] = padding_hu;
}

CloseUp close_up(const GreyVolume& volume, const Vector3d& centre, double half) {
  CloseUp view;
  view.blur = std::cbrt(volume.grid.voxel_volume());
  view.coarsest = volume.grid.spacing().maxCoeff();
  const double step = std::clamp(view.blur, 1.0, 3.0);
  auto& g = view.hu.grid;
  const auto n = static_cast<std::int64_t>(std::ceil(half / step));
  g.size = {2 * n + 1, 2 * n + 1, 2 * n + 1};
  g.axes = step * Eigen::Matrix3d::Identity();
  g.origin = centre - Vector3d::Constant(step * static_cast<double>(n));
  view.hu.voxels.resize(g.count());
  const Eigen::Matrix3d to_index = volume.grid.axes.inverse();
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.point(i, j, k);
        double value = 0;
        const bool inside = sample(volume, to_index * (p - volume.grid.origin), value);
        view.hu.at(i, j, k) = inside ? std::round(hu_of(value, volume.quantity)) : padding_hu;
      }
  return view;
}

std::vector<double> falls_along(const CloseUp& view, const Vector3d& from, const Vector3d& direction,
                                double least, double most) {
  const double width = std::clamp(view.blur, 1.0, 3.0), dr = width / 4;
  constexpr int half = 3;  // half the width of a fall, in steps
  const auto wanted = static_cast<int>((most - least) / dr) + 1 + 4 * half;
  const double start = least - 2 * half * dr;
  std::array<double, most_samples> level;
  int count = std::min<int>(wanted, most_samples);
  view.along(from + start * direction, dr * direction, count, level.data());
  // the scan's end is no bone edge
  const auto first = std::find_if(level.begin(), level.begin() + count, [](double v) { return v > unseen; });
  count = static_cast<int>(std::find_if(first, level.begin() + count, [](double v) { return v <= unseen; }) -
                           level.begin());
  for (int n = 0; n < count; ++n)
    level[static_cast<std::size_t>(n)] = std::clamp(level[static_cast<std::size_t>(n)], lowest, highest);
  const auto fall = [&](int n) {
    return level[static_cast<std::size_t>(n - half)] - level[static_cast<std::size_t>(n + half)];
  };
  std::vector<double> found;
  for (int n = 2 * half; n + 2 * half < count; ++n) {
    if (fall(n) < least_fall || fall(n) < fall(n - 1) || fall(n) <= fall(n + 1)) continue;
    const auto here = level.begin() + n;
    const double inside = *std::max_element(here - 2 * half, here + 1),
                 outside = *std::min_element(here, here + 2 * half + 1), middle = 0.5 * (inside + outside);
    double r = start + n * dr;
    for (int q = n - 2 * half + 1; q <= n + 2 * half; ++q) {
      const double before = level[static_cast<std::size_t>(q - 1)],
                   after = level[static_cast<std::size_t>(q)];
      if (before >= middle && after < middle) {
        r = start + (q - (middle - after) / (before - after)) * dr;
        break;
      }
    }
    if (r >= least && r <= most && (found.empty() || r - found.back() > dr)) found.push_back(r);
  }
  return found;
}

std::vector<Vector3d> even_directions(int count) {
  std::vector<Vector3d> out;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int n = 0; n < count; ++n) {
    const double z = 1 - (2 * n + 1.0) / count, r = std::sqrt(1 - z * z);
    out.emplace_back(r * std::cos(golden * n), r * std::sin(golden * n), z);
  }
  return out;
}

}  // namespace borelli
