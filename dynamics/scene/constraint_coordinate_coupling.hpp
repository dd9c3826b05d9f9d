// Holonomic constraint: a linear relation between scalar coordinates (gear, rack and pinion), or a coordinate
// prescribed as a function of time.
#pragma once

#include <string_view>
#include <vector>

#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// sum_i ratios[i] q_i - value(t) = 0: one row, in the units of the coordinates times their ratios.
struct CoordinateCoupling {
  static constexpr std::string_view kind = "coordinate_coupling";
  std::vector<CoordinateName> coordinates;
  std::vector<double> ratios;  ///< one per coordinate
  TimeFunction value = constant(0);

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("coordinates", self.coordinates);
    visit("ratios", self.ratios);
    visit("value", self.value);
  }

  std::string complaint() const {
    if (coordinates.empty()) return "couples no coordinates; name at least one";
    return coordinates.size() == ratios.size() ? "" : "needs one ratio per coordinate";
  }

  static constexpr int rows = 1;
  static constexpr int length_rows = 0;  ///< number of leading rows in m

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    const TimeValue asked = at(value, pass.time());
    T sum = 0;
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      sum += ratios[i] * pass.position(int(i));
      pass.coordinate(0, int(i), ratios[i]);
    }
    pass.residual(0, sum - asked.value, -asked.rate, -asked.acceleration);
  }
};

}  // namespace borelli
