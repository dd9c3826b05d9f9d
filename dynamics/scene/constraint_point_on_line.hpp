// Holonomic constraint: a point stays on a straight line fixed in a solid or in the world (a slot, a bead on
// a wire).
#pragma once

#include <string_view>

#include "dynamics/scene/constraint_point_on_plane.hpp"
#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// e_i . (p - p_line) = 0 for two directions e_i normal to the line, fixed in its solid: two rows, m.
struct PointOnLine {
  static constexpr std::string_view kind = "point_on_line";
  SolidPoint point;
  SolidPoint line;                                  ///< a point of the line, in the solid that carries it
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< direction of the line, in that solid's axes

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("point", self.point);
    visit("line", self.line);
    visit("axis", self.axis);
  }

  std::string complaint() const { return axis.norm() > 1e-12 ? "" : "its line's axis has no direction"; }

  static constexpr int rows = 2;
  static constexpr int length_rows = 2;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { point_site, line_site };
    const Eigen::Vector3d e = across<double>(axis);
    point_on_plane_row(pass, 0, point_site, point.point, line_site, line.point, e, {});
    point_on_plane_row(pass, 1, point_site, point.point, line_site, line.point, axis.cross(e), {});
  }
};

}  // namespace borelli
