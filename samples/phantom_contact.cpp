#include "samples/phantom_contact.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace borelli {
namespace {

using Eigen::Vector3d;

int root_of(const std::vector<PhantomSolid>& solids, int solid) {
  while (solids[static_cast<std::size_t>(solid)].parent >= 0)
    solid = solids[static_cast<std::size_t>(solid)].parent;
  return solid;
}

struct Bounds {
  Vector3d low = Vector3d::Constant(1e30), high = Vector3d::Constant(-1e30);
};

Bounds box_of(const EllipticStack& shape) {
  Bounds box;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d local;
    for (int c = 0; c < 3; ++c) local[c] = corner >> c & 1 ? shape.box_high()[c] : shape.box_low()[c];
    box.low = box.low.cwiseMin(shape.frame().point(local));
    box.high = box.high.cwiseMax(shape.frame().point(local));
  }
  // planes along the patient's axes (most are) shrink it
  for (const HalfSpace& cut : shape.cuts())
    for (int c = 0; c < 3; ++c) {
      if (cut.normal[c] > 1 - 1e-12) box.high[c] = std::min(box.high[c], cut.offset);
      if (cut.normal[c] < -1 + 1e-12) box.low[c] = std::max(box.low[c], -cut.offset);
    }
  return box;
}

// A root with its box and all solids nested in it, the innermost last.
struct Root {
  std::size_t first, last;  // indices of solids, both included
  Bounds box;
};

}  // namespace

std::vector<PhantomSolid> by_root(std::vector<PhantomSolid> solids) {
  std::vector<int> order(solids.size()), place(solids.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return root_of(solids, a) < root_of(solids, b); });
  std::vector<PhantomSolid> sorted;
  for (const int n : order) {
    place[static_cast<std::size_t>(n)] = static_cast<int>(sorted.size());
    sorted.push_back(solids[static_cast<std::size_t>(n)]);
  }
  for (PhantomSolid& solid : sorted)
    if (solid.parent >= 0) solid.parent = place[static_cast<std::size_t>(solid.parent)];
  return sorted;
}

std::vector<SharedPlace> shared_places(const std::vector<PhantomSolid>& solids) {
  constexpr double step = 2;
  std::vector<Root> roots;
  for (std::size_t n = 0; n < solids.size(); ++n) {
    if (solids[n].parent < 0)
      roots.push_back({n, n, box_of(solids[n].shape)});
    else
      roots.back().last = n;
  }
  std::map<std::pair<std::size_t, std::size_t>, Eigen::Matrix4d> lost;
  for (std::size_t l = 0; l < roots.size(); ++l)
    for (std::size_t w = l + 1; w < roots.size(); ++w) {
      const Root &loser = roots[l], &winner = roots[w];
      const Vector3d low = loser.box.low.cwiseMax(winner.box.low) + Vector3d::Constant(0.37 * step),
                     high = loser.box.high.cwiseMin(winner.box.high);
      for (double z = low.z(); z < high.z(); z += step)
        for (double y = low.y(); y < high.y(); y += step)
          for (double x = low.x(); x < high.x(); x += step) {
            const Vector3d p(x, y, z);
            const auto in = [&](std::size_t n) { return solids[n].shape.holds(p); };
            if (!in(winner.first) || !in(loser.first)) continue;
            // of three roots that share a point each loses it once, to the next one
            bool counted = false;
            for (std::size_t other = l + 1; other < w && !counted; ++other) counted = in(roots[other].first);
            if (counted) continue;
            std::size_t inner = loser.last, taken = winner.last;
            while (!in(inner)) --inner;
            while (!in(taken)) --taken;
            const Eigen::Vector4d q(x, y, z, 1);
            lost.try_emplace({inner, taken}, Eigen::Matrix4d::Zero()).first->second +=
                step * step * step * q * q.transpose();
          }
    }
  std::vector<SharedPlace> shared;
  for (const auto& [solids_there, moments] : lost)
    shared.push_back({solids_there.first, solids_there.second, moments});
  return shared;
}

}  // namespace borelli
