// Holonomic constraint: a point of one solid stays on a point of another, or of the world.
#pragma once

#include <string_view>

#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// p_a - p_b = 0 in world axes: three rows, m.
struct PointOnPoint {
  static constexpr std::string_view kind = "point_on_point";
  SolidPoint a, b;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
  }

  static constexpr int rows = 3;
  static constexpr int length_rows = 3;  ///< number of leading rows in m

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { a_site, b_site };
    const Eigen::Vector3<T> pa = pass.point(a_site, a.point).p, pb = pass.point(b_site, b.point).p;
    for (int r = 0; r < 3; ++r) {
      const Eigen::Vector3<T> axis = Eigen::Vector3<T>::Unit(r);
      pass.along(r, a_site, pa, axis);
      pass.along(r, b_site, pb, -axis);
      pass.residual(r, pa[r] - pb[r], 0, 0);
    }
  }
};

}  // namespace borelli
