// A spring and damper between two points: of two solids, or of a solid and the world.
#pragma once

#include <string_view>

#include "dynamics/site.hpp"

namespace borelli {

class EffortScan;

/// Pulls a and b together with stiffness (l - rest_length) + damping dl/dt along the line between them, l
/// their distance. At l = 0 the line has no direction and the force is zero.
struct PointSpring {
  static constexpr std::string_view kind = "point_spring";
  SolidPoint a, b;
  double stiffness = 0;    ///< N/m
  double damping = 0;      ///< N s/m
  double rest_length = 0;  ///< m

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("stiffness", self.stiffness);
    visit("damping", self.damping);
    visit("rest_length", self.rest_length);
  }

  void apply(EffortScan& scan) const;
};

}  // namespace borelli
