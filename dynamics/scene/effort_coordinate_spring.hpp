// A spring and damper on one scalar coordinate: a translation's or a rotation's.
#pragma once

#include <string_view>

#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class EffortPass;

/// The generalised force -stiffness (q - rest) - damping dq/dt on a coordinate (N or N m). For a ball use a
/// TorsionSpring between its solids.
struct CoordinateSpring {
  static constexpr std::string_view kind = "coordinate_spring";
  CoordinateName on;
  double stiffness = 0;  ///< N/m or N m/rad
  double damping = 0;    ///< N s/m or N m s/rad
  double rest = 0;       ///< m or rad

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("on", self.on);
    visit("stiffness", self.stiffness);
    visit("damping", self.damping);
    visit("rest", self.rest);
  }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { on_coordinate };
    const T stretch = pass.position(on_coordinate) - rest, rate = pass.rate(on_coordinate);
    pass.coordinate(on_coordinate, -stiffness * stretch - damping * rate);
    pass.potential(0.5 * stiffness * stretch * stretch);
    pass.power(-damping * rate * rate);
  }
};

}  // namespace borelli
