#include "segmentation/body/tissues.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "threads/slabs.hpp"

namespace borelli {
namespace {

// largest section of a marrow cavity (femoral condyles or a vertebra), mm^2
constexpr double marrow_section = 3500;
// smallest piece that counts as bone, mm^3 (a finger's phalanx has about 500)
constexpr double smallest_bone = 250;

// Bounding box of bone in a slice perpendicular to one axis, along the other two axes; empty if last < first.
struct Frame {
  std::array<std::int64_t, 2> first{1, 1}, last{0, 0};

  bool empty() const { return last[0] < first[0]; }
  void add(std::int64_t u, std::int64_t v) {
    if (empty()) {
      first = last = {u, v};
      return;
    }
    first = {std::min(first[0], u), std::min(first[1], v)};
    last = {std::max(last[0], u), std::max(last[1], v)};
  }
};

std::vector<Frame> frames_of(const Mask& bone, int c) {
  const auto& g = bone.grid;
  std::vector<Frame> frames(static_cast<std::size_t>(g.size[static_cast<std::size_t>(c)]));
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j) {
      const std::uint8_t* const row = bone.voxels.data() + g.offset(0, j, k);
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const void* const set = std::memchr(row + i, 1, static_cast<std::size_t>(g.size[0] - i));
        if (!set) break;
        i = static_cast<const std::uint8_t*>(set) - row;
        const std::array<std::int64_t, 3> at{i, j, k};
        frames[static_cast<std::size_t>(at[static_cast<std::size_t>(c)])].add(c == 0 ? j : i, c == 2 ? j : k);
      }
    }
  return frames;
}

// Fills hollows of bone within slices perpendicular to axis `c`, up to the section of a marrow cavity.
void fill_sections(Mask& bone, int c, double step, int threads) {
  const auto& g = bone.grid;
  const std::array<int, 2> in{c == 0 ? 1 : 0, c == 2 ? 1 : 2};
  const auto most = static_cast<std::size_t>(marrow_section / (step * step));
  const auto frames = frames_of(bone, c);
  in_turns(std::ssize(frames), threads, [&](std::int64_t w0, std::int64_t w1) {
    std::vector<std::uint8_t> done;
    std::vector<std::int64_t> hollow;
    for (std::int64_t w = w0; w < w1; ++w) {
      // a hollow that reaches the frame's side is open: there is no bone beyond the frame
      const Frame& frame = frames[static_cast<std::size_t>(w)];
      if (frame.empty()) continue;
      const std::int64_t nu = frame.last[0] - frame.first[0] + 1, nv = frame.last[1] - frame.first[1] + 1;
      const auto offset = [&](std::int64_t u, std::int64_t v) {
        std::array<std::int64_t, 3> at{};
        at[static_cast<std::size_t>(c)] = w;
        at[static_cast<std::size_t>(in[0])] = frame.first[0] + u;
        at[static_cast<std::size_t>(in[1])] = frame.first[1] + v;
        return g.offset(at[0], at[1], at[2]);
      };
      done.resize(static_cast<std::size_t>(nu * nv));
      for (std::int64_t v = 0; v < nv; ++v)
        for (std::int64_t u = 0; u < nu; ++u)
          done[static_cast<std::size_t>(v * nu + u)] = bone.voxels[offset(u, v)];
      for (std::int64_t start = 0; start < nu * nv; ++start) {
        if (done[static_cast<std::size_t>(start)]) continue;
        hollow.assign(1, start);
        done[static_cast<std::size_t>(start)] = 1;
        bool closed = true;
        const auto visit = [&](std::int64_t n) {
          auto& seen = done[static_cast<std::size_t>(n)];
          if (!seen) hollow.push_back(n);
          seen = 1;
        };
        for (std::size_t n = 0; n < hollow.size(); ++n) {
          const std::int64_t at = hollow[n], u = at % nu, v = at / nu;
          if (u == 0 || v == 0 || u + 1 == nu || v + 1 == nv) closed = false;
          if (u > 0) visit(at - 1);
          if (u + 1 < nu) visit(at + 1);
          if (v > 0) visit(at - nu);
          if (v + 1 < nv) visit(at + nu);
        }
        if (closed && hollow.size() <= most)
          for (const auto n : hollow) bone.voxels[offset(n % nu, n / nu)] = 1;
      }
    }
  });
}

}  // namespace

Mask bone_mask(const WorkVolume& scan, const Mask& body, int threads) {
  const double step = scan.hu.grid.axes.col(0).norm();
  Mask bone = where(scan.hu.grid, [&](std::size_t o) {
    return body.voxels[o] && tissue_of(scan.hu.voxels[o]) == Tissue::bone;
  });
  for (int c = 2; c >= 0; --c) fill_sections(bone, c, step, threads);
  const double smallest = smallest_bone / (step * step * step);
  return kept_regions(bone, 26, [&](const Region& piece, const Region&) {
    return static_cast<double>(piece.voxels) >= smallest;
  });
}

}  // namespace borelli
