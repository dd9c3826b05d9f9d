#include "dynamics/scene/convex_hull.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace borelli {
namespace {

using Eigen::Vector3d;

// Owns Qhull's state.
struct Hull {
  qhT state;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> quiet{std::fopen("/dev/null", "w"), &std::fclose};
  Hull() { qh_zero(&state, quiet.get()); }
  ~Hull() {
    int left = 0, total = 0;
    qh_freeqhull(&state, !qh_ALL);
    qh_memfreeshort(&state, &left, &total);
  }
  Hull(const Hull&) = delete;
  Hull& operator=(const Hull&) = delete;
};

}  // namespace

Result<ClosedMesh> convex_hull(const std::vector<Vector3d>& points, int most_vertices) {
  for (const Vector3d& p : points)
    if (!p.allFinite()) return bad_use("mesh", "contains a vertex that is not finite");
  if (points.size() < 4) return bad_use("mesh", "has fewer than 4 points, so it has no hull");
  std::vector<double> numbers;
  for (const Vector3d& p : points) numbers.insert(numbers.end(), {p.x(), p.y(), p.z()});
  std::string options = "qhull Qt";
  // Qhull's "TA" counts points added to the first simplex.
  if (most_vertices > 3) options += fmt::format(" Q9 TA{}", most_vertices - 4);
  Hull hull;
  if (!hull.quiet) return failure("mesh", "its hull cannot be computed: cannot open /dev/null");
  qhT* const qh = &hull.state;
  if (qh_new_qhull(qh, 3, static_cast<int>(points.size()), numbers.data(), 0, options.data(),
                   hull.quiet.get(), hull.quiet.get()) != 0)
    return bad_use("mesh", "has no convex hull: its points lie in one plane, or nearly so");

  ClosedMesh out;
  out.vertices = points;
  Vector3d inside = Vector3d::Zero();
  int corners = 0;
  vertexT *vertex, **vertexp;
  FORALLvertices inside += points[static_cast<std::size_t>(qh_pointid(qh, vertex->point))], ++corners;
  inside /= corners;
  facetT* facet;
  FORALLfacets {
    std::array<int, 3> t{};
    int k = 0;
    FOREACHvertex_(facet->vertices) if (k < 3) t[static_cast<std::size_t>(k++)] =
        qh_pointid(qh, vertex->point);
    const auto at = [&](int i) -> const Vector3d& {
      return points[static_cast<std::size_t>(t[static_cast<std::size_t>(i)])];
    };
    if ((at(1) - at(0)).cross(at(2) - at(0)).dot(at(0) - inside) < 0) std::swap(t[1], t[2]);
    out.triangles.push_back(t);
  }
  return out;
}

}  // namespace borelli
