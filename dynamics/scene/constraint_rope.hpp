// Unilateral constraint: the distance of two points does not exceed the length of a rope.
#pragma once

#include <cmath>
#include <string_view>

#include "dynamics/scene/constraint_distance.hpp"
#include "dynamics/scene/contact.hpp"

namespace borelli {

/// length - |p_a - p_b| >= 0: one contact without friction, m.
struct Rope {
  static constexpr std::string_view kind = "rope";
  SolidPoint a, b;
  double length = 1;  ///< m
  double restitution = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("length", self.length);
    visit("restitution", self.restitution);
  }

  std::string complaint() const {
    return length > 0 ? ContactSurface{.restitution = restitution}.complaint()
                      : "its length must be positive";
  }

  static constexpr int rows = 1;
  static constexpr int length_rows = 1;
  static constexpr int contact_rows = 1;

  // Where the points coincide the rope is slack, so that it needs no direction.
  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    distance_row(pass, a, b, {.value = length}, -1);
  }
};

}  // namespace borelli
