// Holonomic constraint: a coordinate is a function of another (offset gear, cam, translations of a knee with
// its flexion).
#pragma once

#include <string_view>

#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// q_on - f(q_of) = 0: one row, m or rad. f is a TimeFunction with q_of (m or rad) as its argument instead of
/// time. compile() turns each `Coupled` switch into such a constraint.
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
  static constexpr int length_rows = 0;  ///< number of leading rows in m

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { on_coordinate, of_coordinate };
    const T rate = pass.rate(of_coordinate);
    const TimeValueOf<T> f = at(function, pass.position(of_coordinate));
    pass.coordinate(0, on_coordinate, T(1));
    pass.coordinate(0, of_coordinate, -f.rate);
    pass.residual(0, pass.position(on_coordinate) - f.value, T(0), -f.acceleration * rate * rate);
  }
};

}  // namespace borelli
