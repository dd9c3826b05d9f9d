// The convex hull of points, by the Qhull library.
#pragma once

#include <vector>

#include "dynamics/scene/shape.hpp"
#include "error/error.hpp"

namespace borelli {

/// The triangles of the hull, counter-clockwise seen from outside, with all `points` as vertices.
/// `most_vertices` above 3 limits the hull to that many corners, farthest points first (MuJoCo's
/// maxhullvert). Errors: points that are not finite, fewer than 4, or in one plane.
Result<ClosedMesh> convex_hull(const std::vector<Eigen::Vector3d>& points, int most_vertices = -1);

}  // namespace borelli
