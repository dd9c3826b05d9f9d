#include "segmentation/joints/half_turns.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "threads/slabs.hpp"

namespace borelli {
namespace {

// Height over which midline bone is clearly nearer to the back's skin, or to the front's, mm.
struct Nearer {
  double back = 0, front = 0;
};

// Distance from the skin inwards to the first bone along j, at column i of slice k, from the front (`inwards`
// +1) or the back (-1), mm. Empty if there is no bone, or no skin in view.
std::optional<double> below_skin(const Anatomy& a, std::int64_t i, std::int64_t k, int inwards) {
  const auto ny = a.grid().size[1];
  std::int64_t j = inwards > 0 ? 0 : ny - 1;
  const auto in_grid = [&] { return j >= 0 && j < ny; };
  while (in_grid() && !a.body.at(i, j, k)) j += inwards;
  if (!in_grid() || j - inwards < 0 || j - inwards >= ny || !a.scan.seen.at(i, j - inwards, k))
    return std::nullopt;
  for (const auto skin = j; in_grid(); j += inwards)
    if (a.bone.at(i, j, k)) return a.step() * static_cast<double>(std::abs(j - skin));
  return std::nullopt;
}

Nearer nearer_skin(const Anatomy& a) {
  constexpr double half_width = 15, much = 40;  // mm
  const auto& g = a.grid();
  const auto half = std::lround(half_width / a.step());
  std::vector<Nearer> by_slice(static_cast<std::size_t>(g.size[2]));
  const auto compare_slice = [&](std::int64_t k) {
    // the midline of the deepest flesh: the trunk's rather than the arms'
    double sum = 0, weight = 0;
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const float depth = a.depth.at(i, j, k);
        if (depth == 0) continue;
        const double w = std::pow(depth, 2);
        sum += w * static_cast<double>(i), weight += w;
      }
    if (weight == 0) return;
    const auto middle = std::lround(sum / weight);
    double front = 1e9, back = 1e9;
    for (auto i = std::max<std::int64_t>(0, middle - half); i <= std::min(g.size[0] - 1, middle + half);
         ++i) {
      front = std::min(front, below_skin(a, i, k, 1).value_or(1e9));
      back = std::min(back, below_skin(a, i, k, -1).value_or(1e9));
    }
    if (front > 1e8 || back > 1e8) return;
    if (front > back + much) by_slice[static_cast<std::size_t>(k)].back = a.step();
    if (back > front + much) by_slice[static_cast<std::size_t>(k)].front = a.step();
  };
  in_turns(g.size[2], a.threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) compare_slice(k);
  });
  Nearer out;
  for (const Nearer& slice : by_slice) out.back += slice.back, out.front += slice.front;
  return out;
}

// Bone of the midline below the level of the hips, behind and in front of them, ml.
struct Pubis {
  double behind = 0, in_front = 0;
};

Pubis pubis_beside(const std::array<std::optional<FoundSphere>, 2>& hips, double scale, const Anatomy& a) {
  Pubis out;
  if (!hips[0] || !hips[1]) return out;
  constexpr double half_width = 25, deep = 60, near = 10, far = 110;  // mm
  const Eigen::Vector3d middle = 0.5 * (hips[0]->centre + hips[1]->centre);
  const auto& g = a.grid();
  const double each = std::pow(a.step(), 3) * 1e-3;
  const auto index = [&](int axis, double off) {
    return std::clamp<std::int64_t>(std::lround((middle[axis] + off * scale - g.origin[axis]) / a.step()), 0,
                                    g.size[static_cast<std::size_t>(axis)]);
  };
  for (auto k = index(2, -deep); k < index(2, 0); ++k)
    for (auto j = index(1, -far); j < index(1, far); ++j)
      for (auto i = index(0, -half_width); i < index(0, half_width); ++i) {
        if (!a.bone.at(i, j, k)) continue;
        const double back = g.point(i, j, k)[1] - middle[1];
        if (back > near * scale) out.behind += each;
        if (back < -near * scale) out.in_front += each;
      }
  return out;
}

bool is_upside_down(const Anatomy& a, const Trunk& trunk) {
  if (trunk.lungs[1] <= trunk.lungs[0]) return false;
  const auto& g = a.grid();
  const auto slice = static_cast<std::size_t>(g.size[0] * g.size[1]);
  double above = 0, beside = 0, below = 0;
  for (std::size_t o = 0; o < a.body.voxels.size(); ++o) {
    if (!a.body.voxels[o]) continue;
    const double z = g.origin[2] + a.step() * static_cast<double>(o / slice);
    (z > trunk.lungs[1] ? above : z < trunk.lungs[0] ? below : beside) += 1;
  }
  return above > beside && above > 2 * below;
}

}  // namespace

std::optional<Eigen::Matrix3d> half_turn(const Anatomy& a, const Trunk& trunk) {
  constexpr double enough = 120;  // mm
  const Nearer nearer = nearer_skin(a);
  // a scan of the pelvis alone shows too little of the back
  constexpr double little = 60, of_pubis = 8;  // mm, ml
  const Pubis pubis = pubis_beside(trunk.hip, trunk.scale, a);
  const bool pubis_behind =
      nearer.back < little && pubis.behind > of_pubis && pubis.behind > 4 * pubis.in_front;
  const bool backwards = pubis_behind || (nearer.front > enough && nearer.front > 3 * nearer.back),
             down = is_upside_down(a, trunk);
  if (!backwards && !down) return std::nullopt;
  const double back = backwards ? -1 : 1, up = down ? -1 : 1;
  return Eigen::Vector3d(back * up, back, up).asDiagonal().toDenseMatrix();
}

std::string words_of_half_turn(const Eigen::Matrix3d& axes) {
  std::string what;
  if (axes(1, 1) < 0) what = "its spine lies where the header says front";
  if (axes(2, 2) < 0)
    what += std::string(what.empty() ? "" : ", and ") + "its feet point to where the header says head";
  return "the header contradicts the body: " + what +
         " (its patient position is wrong or missing). The parts follow the body, half a turn from the "
         "header; " +
         (axes(0, 0) < 0
              ? "left and right follow the body and are swapped against the header; if the file is mirrored "
                "instead, exchange them"
              : "left and right follow the header; if the file is mirrored instead, exchange them");
}

}  // namespace borelli
