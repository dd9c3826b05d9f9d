// Fewer triangles for a closed surface, within a distance, and closed as before.
//
// Edge collapse by quadric error (Garland, Heckbert (1997) "Surface simplification using quadric error
// metrics", SIGGRAPH, 209-216). An edge is collapsed only where its ends share exactly the two neighbours
// across it (the link condition: Dey, Edelsbrunner, Guha, Nekhayev (1999) Publ. Inst. Math. 66:23-45) and no
// triangle turns over; so a closed surface stays closed, of the same genus and with all its pieces.
// (vtkQuadricDecimation does not check that: on thin folds and on pieces of a few triangles it leaves edges
// with one triangle or with three.)
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace borelli {

struct TriangleSurface {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into points
};

/// Collapses edges as long as every point of `surface` stays within `tolerance` (unit of the points) of the
/// new surface, which is measured. `surface` is closed.
TriangleSurface decimate(const TriangleSurface& surface, double tolerance);

/// Whether each edge belongs to exactly two triangles, which pass it in opposite senses.
bool is_closed(std::size_t points, const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace borelli
