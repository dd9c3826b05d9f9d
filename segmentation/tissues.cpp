#include "segmentation/tissues.hpp"

#include <algorithm>
#include <array>

namespace borelli {
namespace {

// a marrow cavity's section (the widest: a femur's condyles or a vertebra), mm^2
constexpr double marrow_section = 3500;
// the smallest piece that is taken for bone, mm^3 (a finger's phalanx has some 500)
constexpr double smallest_bone = 250;

// fills hollows of bone within slices square to axis `c`, up to the section of a marrow cavity
void fill_sections(Mask& bone, int c, double step) {
  const auto& g = bone.grid;
  const std::array<int, 2> in{c == 0 ? 1 : 0, c == 2 ? 1 : 2};
  const std::int64_t nu = g.size[static_cast<std::size_t>(in[0])],
                     nv = g.size[static_cast<std::size_t>(in[1])];
  const auto most = static_cast<std::size_t>(marrow_section / (step * step));
  std::vector<std::uint8_t> done(static_cast<std::size_t>(nu * nv));
  std::vector<std::int64_t> hollow;
  for (std::int64_t w = 0; w < g.size[static_cast<std::size_t>(c)]; ++w) {
    const auto offset = [&](std::int64_t u, std::int64_t v) {
      std::array<std::int64_t, 3> at{};
      at[static_cast<std::size_t>(c)] = w;
      at[static_cast<std::size_t>(in[0])] = u;
      at[static_cast<std::size_t>(in[1])] = v;
      return g.offset(at[0], at[1], at[2]);
    };
    std::fill(done.begin(), done.end(), 0);
    for (std::int64_t v = 0; v < nv; ++v)
      for (std::int64_t u = 0; u < nu; ++u)
        done[static_cast<std::size_t>(v * nu + u)] = bone.voxels[offset(u, v)];
    for (std::int64_t start = 0; start < nu * nv; ++start) {
      if (done[static_cast<std::size_t>(start)]) continue;
      hollow.assign(1, start);
      done[static_cast<std::size_t>(start)] = 1;
      bool closed = true;
      for (std::size_t n = 0; n < hollow.size(); ++n) {
        const std::int64_t u = hollow[n] % nu, v = hollow[n] / nu;
        if (u == 0 || v == 0 || u + 1 == nu || v + 1 == nv) closed = false;
        const std::array<std::array<std::int64_t, 2>, 4> around{
            {{u - 1, v}, {u + 1, v}, {u, v - 1}, {u, v + 1}}};
        for (const auto& a : around) {
          if (a[0] < 0 || a[1] < 0 || a[0] >= nu || a[1] >= nv) continue;
          auto& seen = done[static_cast<std::size_t>(a[1] * nu + a[0])];
          if (seen) continue;
          seen = 1;
          hollow.push_back(a[1] * nu + a[0]);
        }
      }
      if (closed && hollow.size() <= most)
        for (const auto n : hollow) bone.voxels[offset(n % nu, n / nu)] = 1;
    }
  }
}

}  // namespace

Mask bone_mask(const WorkVolume& scan, const Mask& body) {
  const double step = scan.hu.grid.axes.col(0).norm();
  Mask bone{scan.hu.grid, std::vector<std::uint8_t>(scan.hu.voxels.size())};
  for (std::size_t o = 0; o < bone.voxels.size(); ++o)
    bone.voxels[o] = body.voxels[o] && tissue_of(scan.hu.voxels[o]) == Tissue::bone;
  for (int c = 2; c >= 0; --c) fill_sections(bone, c, step);
  const Regions pieces = connected_regions(bone);
  const double smallest = smallest_bone / (step * step * step);
  for (std::size_t o = 0; o < bone.voxels.size(); ++o)
    if (const auto number = pieces.number.voxels[o])
      bone.voxels[o] =
          static_cast<double>(pieces.list[static_cast<std::size_t>(number - 1)].voxels) >= smallest;
  return bone;
}

}  // namespace borelli
