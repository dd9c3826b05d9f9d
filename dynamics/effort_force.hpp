// A force at a point of a solid, external or internal (an opposite pair).
#pragma once

#include <optional>
#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

class EffortScan;

/// `force` times `factor(t)` acts at `at`; if `reaction` is given, the opposite force acts there.
struct Force {
  static constexpr std::string_view kind = "force";
  SolidPoint at;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< N
  Axes axes = Axes::world;                          ///< of `force`: the world's or those of at.solid
  TimeFunction factor = constant(1);
  std::optional<SolidPoint> reaction;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("at", self.at);
    visit("force", self.force);
    visit("axes", self.axes);
    visit("factor", self.factor);
    visit("reaction", self.reaction);
  }

  void apply(EffortScan& scan) const;
};

}  // namespace borelli
