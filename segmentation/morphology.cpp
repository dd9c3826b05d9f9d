#include "segmentation/morphology.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "segmentation/slabs.hpp"

namespace borelli {
namespace {

constexpr float far_away = 1e12F;

// lower envelope of parabolas: replaces f (squared distances in voxels) of length n, stride apart
struct Line {
  std::vector<float> f, z;
  std::vector<int> v;
  explicit Line(std::int64_t n)
      : f(static_cast<std::size_t>(n)), z(static_cast<std::size_t>(n) + 1), v(static_cast<std::size_t>(n)) {}

  void transform(float* data, std::int64_t n, std::int64_t stride) {
    bool any = false;
    for (std::int64_t i = 0; i < n; ++i) {
      f[static_cast<std::size_t>(i)] = data[i * stride];
      any = any || data[i * stride] < far_away;
    }
    if (!any) return;
    int k = -1;
    for (int q = 0; q < n; ++q) {
      const float fq = f[static_cast<std::size_t>(q)];
      if (fq >= far_away) continue;
      float s = -std::numeric_limits<float>::infinity();
      while (k >= 0) {
        const int p = v[static_cast<std::size_t>(k)];
        s = ((fq - f[static_cast<std::size_t>(p)]) / static_cast<float>(q - p) + static_cast<float>(q + p)) /
            2;
        if (s > z[static_cast<std::size_t>(k)]) break;
        --k;
      }
      if (k < 0) s = -std::numeric_limits<float>::infinity();
      ++k;
      v[static_cast<std::size_t>(k)] = q;
      z[static_cast<std::size_t>(k)] = s;
      z[static_cast<std::size_t>(k) + 1] = std::numeric_limits<float>::infinity();
    }
    int j = 0;
    for (int q = 0; q < n; ++q) {
      while (z[static_cast<std::size_t>(j) + 1] < static_cast<float>(q)) ++j;
      const auto d = static_cast<float>(q - v[static_cast<std::size_t>(j)]);
      data[q * stride] = d * d + f[static_cast<std::size_t>(v[static_cast<std::size_t>(j)])];
    }
  }
};

}  // namespace

Volume<float> distance_to(const Mask& mask, double reach, bool outside_is_set, int threads) {
  const auto& g = mask.grid;
  const std::int64_t nx = g.size[0], ny = g.size[1], nz = g.size[2];
  const double h = g.axes.col(0).norm();
  Volume<float> d{g, std::vector<float>(g.count())};

  // along i: two sweeps, exact; then the envelope along j and k
  in_slabs(nz, threads, [&](std::int64_t k0, std::int64_t k1) {
    Line line(ny);
    for (std::int64_t k = k0; k < k1; ++k) {
      for (std::int64_t j = 0; j < ny; ++j) {
        const std::size_t row = g.offset(0, j, k);
        float run = outside_is_set ? 0 : far_away;
        for (std::int64_t i = 0; i < nx; ++i) {
          run = mask.voxels[row + static_cast<std::size_t>(i)] ? 0 : std::min(run + 1, far_away);
          d.voxels[row + static_cast<std::size_t>(i)] = run;
        }
        run = outside_is_set ? 0 : far_away;
        for (std::int64_t i = nx; i-- > 0;) {
          float& at = d.voxels[row + static_cast<std::size_t>(i)];
          run = std::min(at, std::min(run + 1, far_away));
          at = run;
          if (at < far_away) at *= at;
        }
      }
      for (std::int64_t i = 0; i < nx; ++i) line.transform(&d.voxels[g.offset(i, 0, k)], ny, nx);
    }
  });
  in_slabs(ny, threads, [&](std::int64_t j0, std::int64_t j1) {
    Line line(nz);
    for (std::int64_t j = j0; j < j1; ++j)
      for (std::int64_t i = 0; i < nx; ++i) line.transform(&d.voxels[g.offset(i, j, 0)], nz, nx * ny);
  });
  const auto limit = static_cast<float>(reach);
  in_slabs(nz, threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < ny; ++j)
        for (std::int64_t i = 0; i < nx; ++i) {
          float& at = d.voxels[g.offset(i, j, k)];
          at = std::min(limit, static_cast<float>(h) * std::sqrt(at));
          if (outside_is_set) {
            const auto edge = static_cast<float>(
                h * static_cast<double>(1 + std::min({i, nx - 1 - i, j, ny - 1 - j, k, nz - 1 - k})));
            at = std::min(at, edge);
          }
        }
  });
  return d;
}

Mask complement(const Mask& mask) {
  Mask out{mask.grid, std::vector<std::uint8_t>(mask.voxels.size())};
  std::transform(mask.voxels.begin(), mask.voxels.end(), out.voxels.begin(),
                 [](std::uint8_t v) { return static_cast<std::uint8_t>(v == 0); });
  return out;
}

Mask eroded(const Mask& mask, double radius, bool outside_is_set) {
  const auto d = distance_to(complement(mask), 2 * radius + 1, !outside_is_set);
  Mask out{mask.grid, std::vector<std::uint8_t>(mask.voxels.size())};
  std::transform(d.voxels.begin(), d.voxels.end(), out.voxels.begin(),
                 [r = static_cast<float>(radius)](float v) { return static_cast<std::uint8_t>(v > r); });
  return out;
}

Mask dilated(const Mask& mask, double radius) {
  const auto d = distance_to(mask, 2 * radius + 1);
  Mask out{mask.grid, std::vector<std::uint8_t>(mask.voxels.size())};
  std::transform(d.voxels.begin(), d.voxels.end(), out.voxels.begin(),
                 [r = static_cast<float>(radius)](float v) { return static_cast<std::uint8_t>(v <= r); });
  return out;
}

Regions connected_regions(const Mask& mask, int neighbours) {
  const auto& g = mask.grid;
  Regions out;
  out.number = {g, std::vector<std::int32_t>(g.count(), 0)};
  std::vector<std::array<std::int32_t, 3>> stack;
  std::vector<std::array<int, 3>> steps;
  for (int c = -1; c <= 1; ++c)
    for (int b = -1; b <= 1; ++b)
      for (int a = -1; a <= 1; ++a) {
        const int faces = std::abs(a) + std::abs(b) + std::abs(c);
        if (faces == 1 || (faces > 1 && neighbours == 26)) steps.push_back({a, b, c});
      }
  std::vector<Region> found;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!mask.at(i, j, k) || out.number.at(i, j, k)) continue;
        Region region{0, {i, j, k}, {i, j, k}, Eigen::Vector3d::Zero()};
        const auto number = static_cast<std::int32_t>(found.size() + 1);
        out.number.at(i, j, k) = number;
        stack.push_back(
            {static_cast<std::int32_t>(i), static_cast<std::int32_t>(j), static_cast<std::int32_t>(k)});
        while (!stack.empty()) {
          const auto at = stack.back();
          stack.pop_back();
          ++region.voxels;
          for (std::size_t c = 0; c < 3; ++c) {
            region.low[c] = std::min<std::int64_t>(region.low[c], at[c]);
            region.high[c] = std::max<std::int64_t>(region.high[c], at[c]);
            region.centre[static_cast<Eigen::Index>(c)] += at[c];
          }
          for (const auto& s : steps) {
            const std::int32_t a = at[0] + s[0], b = at[1] + s[1], c = at[2] + s[2];
            if (!g.holds(a, b, c)) continue;
            const std::size_t o = g.offset(a, b, c);
            if (!mask.voxels[o] || out.number.voxels[o]) continue;
            out.number.voxels[o] = number;
            stack.push_back({a, b, c});
          }
        }
        region.centre /= static_cast<double>(region.voxels);
        found.push_back(region);
      }
  std::vector<std::int32_t> order(found.size()), rank(found.size() + 1, 0);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return found[static_cast<std::size_t>(a)].voxels > found[static_cast<std::size_t>(b)].voxels;
  });
  for (std::size_t n = 0; n < order.size(); ++n) {
    out.list.push_back(found[static_cast<std::size_t>(order[n])]);
    rank[static_cast<std::size_t>(order[n]) + 1] = static_cast<std::int32_t>(n + 1);
  }
  for (auto& v : out.number.voxels) v = rank[static_cast<std::size_t>(v)];
  return out;
}

Mask reached(const Mask& seed, const Mask& mask) {
  const auto& g = mask.grid;
  Mask out{g, std::vector<std::uint8_t>(g.count(), 0)};
  std::vector<std::size_t> stack;
  for (std::size_t o = 0; o < g.count(); ++o)
    if (seed.voxels[o] && mask.voxels[o]) {
      out.voxels[o] = 1;
      stack.push_back(o);
    }
  const auto nx = static_cast<std::size_t>(g.size[0]), ny = static_cast<std::size_t>(g.size[1]),
             nz = static_cast<std::size_t>(g.size[2]);
  const auto visit = [&](std::size_t o) {
    if (!mask.voxels[o] || out.voxels[o]) return;
    out.voxels[o] = 1;
    stack.push_back(o);
  };
  while (!stack.empty()) {
    const std::size_t o = stack.back();
    stack.pop_back();
    const std::size_t i = o % nx, j = o / nx % ny, k = o / nx / ny;
    if (i > 0) visit(o - 1);
    if (i + 1 < nx) visit(o + 1);
    if (j > 0) visit(o - nx);
    if (j + 1 < ny) visit(o + nx);
    if (k > 0) visit(o - nx * ny);
    if (k + 1 < nz) visit(o + nx * ny);
  }
  return out;
}

}  // namespace borelli
