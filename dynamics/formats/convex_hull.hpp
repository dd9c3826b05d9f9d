// The convex hull of points, by the Qhull library.
#pragma once

#include <vector>

#include "dynamics/scene/shape.hpp"
#include "error/error.hpp"

namespace borelli {

/// The hull's triangles, counter-clockwise from outside, over all `points` as vertices. `most_vertices` above
/// 3 limits the hull to that many corners, farthest points first (MuJoCo's maxhullvert). Refuses points that
/// are not finite or lie in one plane.
Result<ClosedMesh> convex_hull(const std::vector<Eigen::Vector3d>& points, int most_vertices = -1);

}  // namespace borelli
