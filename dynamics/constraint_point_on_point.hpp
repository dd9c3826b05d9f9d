// Holonomic constraint: a point of one solid stays on a point of another, or of the world.
#pragma once

#include <string_view>

#include "dynamics/site.hpp"

namespace borelli {

class ConstraintScan;

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
  static constexpr int length_rows = 3;  ///< the first ones, which are in m
  void evaluate(ConstraintScan& scan) const;
};

}  // namespace borelli
