#include "pipeline/export/skin_zones.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/grid/geodesic.hpp"
#include "segmentation/grid/squared_distances.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using Index = std::array<std::int64_t, 3>;

struct PartBox {
  Index first{0, 0, 0}, last{-1, -1, -1};  // empty

  bool empty() const { return last[0] < first[0]; }
  void add(const Index& at) {
    const bool was_empty = empty();
    for (std::size_t c = 0; c < 3; ++c) {
      first[c] = was_empty ? at[c] : std::min(first[c], at[c]);
      last[c] = was_empty ? at[c] : std::max(last[c], at[c]);
    }
  }
};

template <class Visit>
void each_voxel(const Grid& g, const Visit& visit) {
  std::size_t at = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i, ++at) visit(Index{i, j, k}, at);
}

Vector3d as_vector(const Index& at) { return {double(at[0]), double(at[1]), double(at[2])}; }

/// A part of the grid.
Grid cropped(const Grid& grid, const PartBox& box) {
  Grid out = grid;
  for (std::size_t c = 0; c < 3; ++c) out.size[c] = box.last[c] - box.first[c] + 1;
  out.origin = grid.point(as_vector(box.first));
  return out;
}

/// Radius, m, of the largest ball within the two parts whose centre is at most its own distance from the
/// skin away from the joint.
double half_thickness_at(const Vector3d& centre, std::uint8_t part, std::uint8_t parent,
                         const Volume<std::uint8_t>& coarse) {
  constexpr double most_mm = 150;
  const Grid& g = coarse.grid;
  const double step = g.axes(0, 0);  // mm
  const Vector3d at = g.index(1e3 * centre);
  PartBox box;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto middle = static_cast<std::int64_t>(std::lround(at[static_cast<int>(c)]));
    const auto reach = static_cast<std::int64_t>(most_mm / step);
    box.first[c] = std::clamp<std::int64_t>(middle - reach, 0, g.size[c] - 1);
    box.last[c] = std::clamp<std::int64_t>(middle + reach, 0, g.size[c] - 1);
  }
  Volume<std::uint8_t> flesh{cropped(g, box), {}};
  flesh.voxels.resize(flesh.grid.count());
  each_voxel(flesh.grid, [&](const Index& i, std::size_t n) {
    const std::uint8_t here = coarse.at(box.first[0] + i[0], box.first[1] + i[1], box.first[2] + i[2]);
    flesh.voxels[n] = here == part || here == parent;
  });
  const auto most = static_cast<std::uint32_t>(most_mm / step);
  const auto to_skin =
      squared_distances<std::uint32_t>(flesh, most * most, {.to_unset = true, .outside_is_near = true});
  const Vector3d joint = flesh.grid.index(1e3 * centre);
  double here = 0, nearest = 1e30, widest = 0;
  each_voxel(flesh.grid, [&](const Index& i, std::size_t n) {
    const double away = (as_vector(i) - joint).squaredNorm();
    if (away < nearest) nearest = away, here = to_skin.voxels[n];
  });
  const double reach = std::max(here, 9.0);  // a centre on the skin: look three voxels around
  each_voxel(flesh.grid, [&](const Index& i, std::size_t n) {
    if ((as_vector(i) - joint).squaredNorm() <= reach) widest = std::max(widest, double(to_skin.voxels[n]));
  });
  return 1e-3 * step * std::max(1.0, std::sqrt(widest) - 0.5);  // (distances run from centre to centre)
}

/// The only child with a joint, if there is one child.
int only_child(const std::vector<SkinPart>& parts, std::size_t part) {
  int found = -1;
  for (std::size_t n = 0; n < parts.size(); ++n) {
    if (parts[n].parent != static_cast<int>(part)) continue;
    if (found >= 0 || !parts[n].has_joint) return -1;
    found = static_cast<int>(n);
  }
  return found;
}

/// Sets the axis of the joint's twist and the segment that it twists; `taken`: segments that another joint
/// twists.
void choose_twist(std::vector<SkinPart>& parts, std::size_t n, bool twists, const Vector3d& gravity_centre,
                  std::vector<bool>& taken) {
  constexpr double slender = 3;  // half thicknesses
  SkinPart& part = parts[n];
  const auto parent = static_cast<std::size_t>(part.parent);
  const int child = only_child(parts, n);
  const Vector3d down =
      (child >= 0 ? parts[static_cast<std::size_t>(child)].centre : gravity_centre) - part.centre;
  part.axis = down.norm() > 1e-6 ? Vector3d(down.normalized()) : Vector3d::UnitZ();
  if (!twists) return;
  const bool up_free = parts[parent].has_joint && only_child(parts, parent) >= 0 && !taken[parent];
  const Vector3d up = up_free ? Vector3d(part.centre - parts[parent].centre) : Vector3d::Zero();
  const double length_down = child >= 0 && !taken[n] ? down.norm() : 0;
  if (std::max(length_down, up.norm()) < slender * part.half_thickness) return;
  part.twist = length_down >= up.norm() ? TwistAlong::part : TwistAlong::parent;
  if (part.twist == TwistAlong::parent) part.axis = up.normalized();
  taken[part.twist == TwistAlong::part ? n : parent] = true;
}

/// Whether two parts are the same or parent and child.
bool connected(const std::vector<SkinPart>& parts, std::size_t a, std::size_t b) {
  return a == b || parts[a].parent == static_cast<int>(b) || parts[b].parent == static_cast<int>(a);
}

/// Paths from the voxels of the part and of its parent that touch each other, through the parts in `open`.
PathsFromCut paths_from_cut(std::uint8_t part, std::uint8_t parent, const std::array<bool, 256>& open,
                            const PartBox& box, const Volume<std::uint8_t>& coarse) {
  const Grid grid = cropped(coarse.grid, box);
  const auto at = [&](const Index& i) {
    return coarse.at(box.first[0] + i[0], box.first[1] + i[1], box.first[2] + i[2]);
  };
  Volume<float> cost{grid, std::vector<float>(grid.count(), no_path)};
  Volume<std::uint8_t> cut{grid, std::vector<std::uint8_t>(grid.count(), 0)};
  each_voxel(grid, [&](const Index& i, std::size_t n) {
    const std::uint8_t here = at(i);
    if (!open[here]) return;
    cost.voxels[n] = 1;
    if (here != part && here != parent) return;
    const std::uint8_t other = here == part ? parent : part;
    for (std::size_t c = 0; c < 3; ++c)
      for (const std::int64_t step : {-1, 1}) {
        Index beside = i;
        beside[c] += step;
        if (grid.holds(beside[0], beside[1], beside[2]) && at(beside) == other) cut.voxels[n] = 1;
      }
  });
  const Geodesic paths = geodesic(Places(cost, 1), cut, false);
  PathsFromCut out{box.first, grid.size, std::vector<float>(grid.count(), no_path)};
  const double half_step = grid.axes(0, 0) / 2;  // the cut runs between voxels
  for (std::size_t n = 0; n < grid.count(); ++n)
    if (paths.owner.voxels[n]) out.lengths[n] = static_cast<float>(1e-3 * (paths.length(n) + half_step));
  return out;
}

}  // namespace

Volume<std::uint8_t> isotropic_parts(const Volume<std::uint8_t>& body, double step) {
  PartBox box;
  each_voxel(body.grid, [&](const Index& i, std::size_t n) {
    if (body.voxels[n]) box.add(i);
  });
  Vector3d low = Vector3d::Constant(1e30), high = -low;  // mm
  for (int corner = 0; corner < 8; ++corner) {
    Index at{};
    for (std::size_t c = 0; c < 3; ++c) at[c] = corner >> c & 1 ? box.last[c] : box.first[c];
    low = low.cwiseMin(body.grid.point(as_vector(at)));
    high = high.cwiseMax(body.grid.point(as_vector(at)));
  }
  Volume<std::uint8_t> coarse;
  coarse.grid.axes *= 1e3 * step;
  coarse.grid.origin = low;
  for (int c = 0; c < 3; ++c)
    coarse.grid.size[static_cast<std::size_t>(c)] =
        static_cast<std::int64_t>(std::ceil((high - low)[c] / (1e3 * step) - 1e-6)) + 1;
  coarse.voxels.resize(coarse.grid.count());
  const Eigen::Matrix3d to_index = body.grid.axes.inverse();
  each_voxel(coarse.grid, [&](const Index& i, std::size_t n) {
    const Vector3d at = to_index * (coarse.grid.point(as_vector(i)) - body.grid.origin);
    const std::int64_t x = std::lround(at[0]), y = std::lround(at[1]), z = std::lround(at[2]);
    if (body.grid.holds(x, y, z)) coarse.voxels[n] = body.at(x, y, z);
  });
  return coarse;
}

void measure_joints(std::vector<SkinPart>& parts, const std::vector<SkinJoint>& joints,
                    const Volume<std::uint8_t>& coarse) {
  std::vector<Vector3d> sums(parts.size(), Vector3d::Zero());
  std::vector<double> voxels(parts.size(), 0);
  each_voxel(coarse.grid, [&](const Index& i, std::size_t n) {
    if (const std::uint8_t here = coarse.voxels[n]) sums[here - 1U] += as_vector(i), ++voxels[here - 1U];
  });
  for (std::size_t n = 0; n < parts.size(); ++n)
    if (parts[n].has_joint)
      parts[n].half_thickness = half_thickness_at(parts[n].centre, static_cast<std::uint8_t>(n + 1),
                                                  static_cast<std::uint8_t>(parts[n].parent + 1), coarse);
  std::vector<bool> taken(parts.size(), false);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    if (!parts[n].has_joint) continue;
    const Vector3d middle =
        voxels[n] > 0 ? Vector3d(1e-3 * coarse.grid.point(sums[n] / voxels[n])) : parts[n].centre;
    choose_twist(parts, n, joints[n].twists, middle, taken);
  }
}

std::vector<PathsFromCut> paths_from_cuts(const std::vector<SkinPart>& parts,
                                          const Volume<std::uint8_t>& coarse, int threads) {
  std::vector<PartBox> boxes(parts.size());
  each_voxel(coarse.grid, [&](const Index& i, std::size_t n) {
    if (const std::uint8_t here = coarse.voxels[n]) boxes[here - 1U].add(i);
  });
  std::vector<PathsFromCut> paths(parts.size());
  in_turns(std::ssize(parts), threads, [&](std::int64_t from, std::int64_t to) {
    for (auto n = static_cast<std::size_t>(from); n < static_cast<std::size_t>(to); ++n) {
      if (!parts[n].has_joint) continue;
      const auto parent = static_cast<std::size_t>(parts[n].parent);
      std::array<bool, 256> open{};
      PartBox box;
      for (std::size_t m = 0; m < parts.size(); ++m) {
        if (!connected(parts, m, n) && !connected(parts, m, parent)) continue;
        open[m + 1] = true;
        if (boxes[m].empty()) continue;
        box.add(boxes[m].first);
        box.add(boxes[m].last);
      }
      if (!box.empty())
        paths[n] = paths_from_cut(static_cast<std::uint8_t>(n + 1), static_cast<std::uint8_t>(parent + 1),
                                  open, box, coarse);
    }
  });
  return paths;
}

}  // namespace borelli
