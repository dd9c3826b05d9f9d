// Holonomic constraint: a point stays on a plane fixed in a solid or in the world; the plane may move in
// time.
#pragma once

#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

class ConstraintScan;

/// n . (p - p_plane) - offset(t) = 0: one row, m. n is made unit by compile().
struct PointOnPlane {
  static constexpr std::string_view kind = "point_on_plane";
  SolidPoint point;
  SolidPoint plane;                                   ///< a point of the plane, in the solid that carries it
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< in that solid's axes
  TimeFunction offset = constant(0);                  ///< m, along the normal

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("point", self.point);
    visit("plane", self.plane);
    visit("normal", self.normal);
    visit("offset", self.offset);
  }

  std::string complaint() const { return normal.norm() > 1e-12 ? "" : "its plane's normal has no direction"; }

  static constexpr int rows = 1;
  static constexpr int length_rows = 1;  ///< the first ones, which are in m
  void evaluate(ConstraintScan& scan) const;
};

}  // namespace borelli
