#include "tests/suite/body_raster.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "threads/slabs.hpp"

namespace borelli::suite {
namespace {

using Eigen::Matrix3f, Eigen::Vector3f;

// Kuhn's six tetrahedra of a cube around its diagonal 0-7: neighbours share the diagonals of their faces.
constexpr std::array<std::array<std::size_t, 2>, 6> kuhn{{{1, 3}, {1, 5}, {2, 3}, {2, 6}, {4, 5}, {4, 6}}};

struct Cell {
  std::array<Vector3f, 8> corner;  // in indices of the target grid
  std::array<Matrix3f, 6> inverse;
  std::array<bool, 6> usable;

  void prepare() {
    for (std::size_t t = 0; t < 6; ++t) {
      Matrix3f edges;
      edges << corner[kuhn[t][0]] - corner[0], corner[kuhn[t][1]] - corner[0], corner[7] - corner[0];
      const float det = edges.determinant();
      usable[t] = std::abs(det) > 1e-7F;
      if (usable[t]) inverse[t] = edges.inverse();
    }
  }
  bool holds(const Vector3f& p) const {
    constexpr float eps = 1e-4F;
    for (std::size_t t = 0; t < 6; ++t) {
      if (!usable[t]) continue;
      const Vector3f b = inverse[t] * (p - corner[0]);
      if (b.minCoeff() >= -eps && b.sum() <= 1 + eps) return true;
    }
    return false;
  }
};

class Slab {
 public:
  Slab(const LabelledBody& body, BodyRaster& out, std::int64_t first, std::int64_t last)
      : body_(body), out_(out), first_(first), last_(last) {
    claim_.assign(static_cast<std::size_t>((last - first) * out.grid.size[0] * out.grid.size[1]), 0);
  }

  void add(std::uint32_t n, Cell& cell) {
    Vector3f low = cell.corner[0], high = low;
    for (const Vector3f& p : cell.corner) low = low.cwiseMin(p), high = high.cwiseMax(p);
    std::array<std::int64_t, 3> from, to;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto e = static_cast<Eigen::Index>(c);
      from[c] = std::max<std::int64_t>(c == 2 ? first_ : 0, std::int64_t(std::ceil(low[e] - 1e-3F)));
      to[c] = std::min<std::int64_t>((c == 2 ? last_ : out_.grid.size[c]) - 1,
                                     std::int64_t(std::floor(high[e] + 1e-3F)));
      if (from[c] > to[c]) return;
    }
    cell.prepare();
    for (std::int64_t k = from[2]; k <= to[2]; ++k)
      for (std::int64_t j = from[1]; j <= to[1]; ++j)
        for (std::int64_t i = from[0]; i <= to[0]; ++i)
          if (cell.holds(Vector3f(float(i), float(j), float(k)))) claim(out_.grid.offset(i, j, k), n);
  }

  void finish(double& overlap) {
    overlap += double(overlapped_) * out_.grid.voxel_volume();
    const std::size_t begin = out_.grid.offset(0, 0, first_);
    for (std::size_t o = 0; o < claim_.size(); ++o) out_.source[begin + o] = std::uint32_t(claim_[o]);
  }

 private:
  static constexpr std::uint64_t overlap_bit = 1ULL << 63;

  std::uint64_t rank(std::uint32_t n) const {
    const std::uint64_t near = body_.bone[n] ? 256 : 255 - body_.off_bone[n];
    return near << 40 | (std::uint64_t(n) + 1);
  }
  void claim(std::size_t o, std::uint32_t n) {
    std::uint64_t& held = claim_[o - out_.grid.offset(0, 0, first_)];
    const std::uint64_t mine = rank(n);
    if (held == 0) {
      held = mine;
      return;
    }
    std::uint64_t mark = held & overlap_bit;
    const auto other = std::uint32_t(held) - 1;
    if (!mark && (body_.centre(n) - body_.centre(other)).squaredNorm() > 900)
      mark = overlap_bit, ++overlapped_;
    held = std::max(held & ~overlap_bit, mine) | mark;
  }

  const LabelledBody& body_;
  BodyRaster& out_;
  std::int64_t first_, last_;
  std::vector<std::uint64_t> claim_;
  std::int64_t overlapped_ = 0;
};

}  // namespace

BodyRaster rasterise(const LabelledBody& body, const std::vector<Vector3f>& corner,
                     const std::vector<std::uint8_t>& gone, const Grid& grid, int threads) {
  const BodyLattice& lattice = body.lattice;
  BodyRaster out;
  out.grid = grid;
  out.source.assign(grid.count(), 0);
  std::vector<Vector3f> at(corner.size());
  const Eigen::Matrix3d inverse = grid.axes.inverse();
  // a shift, larger than rounding but far below a voxel, so that points on a face belong to one voxel
  const Eigen::Vector3d off_faces(0.0037, 0.0029, 0.0043);
  in_slabs(std::ssize(at), threads, [&](std::int64_t first, std::int64_t last) {
    for (auto c = static_cast<std::size_t>(first); c < static_cast<std::size_t>(last); ++c)
      at[c] = (inverse * (corner[c].cast<double>() - grid.origin) + off_faces).cast<float>();
  });
  std::mutex mutex;
  const std::int64_t depth = std::max<std::int64_t>(1, (grid.size[2] + 3) / 4);
  in_turns((grid.size[2] + depth - 1) / depth, threads, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t s = from; s < to; ++s) {
      const std::int64_t first = s * depth, last = std::min(grid.size[2], first + depth);
      Slab slab(body, out, first, last);
      Cell cell;
      for (std::size_t n = 0; n < lattice.corners.size(); ++n) {
        if (!gone.empty() && gone[n]) continue;
        float low = 1e9F, high = -1e9F;
        for (std::size_t c = 0; c < 8; ++c) {
          const float z = at[lattice.corners[n][c]].z();
          low = std::min(low, z), high = std::max(high, z);
        }
        if (high < float(first) - 0.01F || low > float(last)) continue;
        for (std::size_t c = 0; c < 8; ++c) cell.corner[c] = at[lattice.corners[n][c]];
        slab.add(static_cast<std::uint32_t>(n), cell);
      }
      const std::lock_guard lock(mutex);
      slab.finish(out.overlap);
    }
  });
  return out;
}

}  // namespace borelli::suite
