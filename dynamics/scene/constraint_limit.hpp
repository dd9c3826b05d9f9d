// Unilateral constraint: a coordinate stays between two bounds (a joint's stops).
#pragma once

#include <optional>
#include <string_view>

#include "dynamics/scene/contact.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// q - lower >= 0 and upper - q >= 0: two frictionless contacts, m or rad. A missing bound gives an inactive
/// row.
struct Limit {
  static constexpr std::string_view kind = "limit";
  CoordinateName on;
  std::optional<double> lower, upper;  ///< m or rad
  double restitution = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("on", self.on);
    visit("lower", self.lower);
    visit("upper", self.upper);
    visit("restitution", self.restitution);
  }

  std::string complaint() const {
    if (!lower && !upper) return "has no bound; give lower, upper or both";
    if (lower && upper && !(*lower < *upper)) return "its lower bound must be below its upper one";
    return ContactSurface{.restitution = restitution}.complaint();
  }

  static constexpr int rows = 2;
  static constexpr int length_rows = 0;
  static constexpr int contact_rows = 1;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { on_coordinate };
    const T q = pass.position(on_coordinate);
    pass.coordinate(0, on_coordinate, T(lower ? 1 : 0));
    pass.residual(0, lower ? q - *lower : T(1), T(0), T(0));
    pass.coordinate(1, on_coordinate, T(upper ? -1 : 0));
    pass.residual(1, upper ? *upper - q : T(1), T(0), T(0));
  }
};

}  // namespace borelli
