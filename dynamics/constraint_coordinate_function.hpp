// Holonomic constraint: a coordinate is a function of another (a gear with an offset, a cam, the slide of a
// knee with its flexion).
#pragma once

#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

template <class T>
class ConstraintScan;

/// q_on - f(q_of) = 0: one row, m or rad. f takes q_of in m or rad where it is named as a function of time.
/// Of a switch that is `Coupled`, compile() makes one of these.
struct CoordinateFunction {
  static constexpr std::string_view kind = "coordinate_function";
  CoordinateName on, of;
  TimeFunction function = linear(0, 1);

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("on", self.on);
    visit("of", self.of);
    visit("function", self.function);
  }

  std::string complaint() const {
    return on.coordinate == of.coordinate ? "makes a coordinate a function of itself" : "";
  }

  static constexpr int rows = 1;
  static constexpr int length_rows = 0;  ///< the first ones, which are in m

  template <class T>
  void evaluate(ConstraintScan<T>& scan) const {
    enum { on_coordinate, of_coordinate };
    const T rate = scan.rate(of_coordinate);
    const TimeValueOf<T> f = at(function, scan.position(of_coordinate));
    scan.coordinate(0, on_coordinate, T(1));
    scan.coordinate(0, of_coordinate, -f.rate);
    scan.residual(0, scan.position(on_coordinate) - f.value, T(0), -f.acceleration * rate * rate);
  }
};

}  // namespace borelli
