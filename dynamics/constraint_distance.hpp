// Holonomic constraint: two points keep a distance (a massless rod), which may be a function of time.
#pragma once

#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

class ConstraintScan;

/// |p_a - p_b| - distance(t) = 0: one row, m. The distance must stay positive: at zero the rod has no
/// direction.
struct Distance {
  static constexpr std::string_view kind = "distance";
  SolidPoint a, b;
  TimeFunction distance = constant(1);  ///< m

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("distance", self.distance);
  }

  static constexpr int rows = 1;
  static constexpr int length_rows = 1;  ///< the first ones, which are in m
  void evaluate(ConstraintScan& scan) const;
};

}  // namespace borelli
