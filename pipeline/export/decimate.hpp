// Reduces the triangles of a closed surface within a distance; the surface stays closed.
//
// Edge collapse by quadric error (Garland, Heckbert (1997) "Surface simplification using quadric error
// metrics", SIGGRAPH, 209-216). An edge is collapsed only if its ends share exactly the two vertices opposite
// it (link condition: Dey, Edelsbrunner, Guha, Nekhayev (1999) Publ. Inst. Math. 66:23-45) and no triangle
// flips. So a closed surface stays closed and keeps its genus and all its pieces. (vtkQuadricDecimation does
// not check the link condition: on thin folds and on pieces of a few triangles it leaves edges with one or
// three triangles.)
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace borelli {

struct TriangleSurface {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into points
};

/// Collapses edges as long as every point of the closed `surface` stays within `tolerance` (unit of the
/// points) of the new surface. This distance is measured. No collapse leaves an edge longer than
/// `longest_edge` (same unit).
TriangleSurface decimate(const TriangleSurface& surface, double tolerance,
                         double longest_edge = std::numeric_limits<double>::infinity());

/// Whether each edge belongs to exactly two triangles with opposite directions along it.
bool is_closed(std::size_t points, const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace borelli
