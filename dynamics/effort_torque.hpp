// A torque on a solid, external or internal (an opposite pair).
#pragma once

#include <optional>
#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

class EffortScan;

/// `torque` times `factor(t)` acts on `on`; if `reaction` is given, the opposite torque acts there.
struct Torque {
  static constexpr std::string_view kind = "torque";
  SolidName on;
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  ///< N m
  Axes axes = Axes::world;                           ///< of `torque`: the world's or those of on.solid
  TimeFunction factor = constant(1);
  std::optional<SolidName> reaction;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("on", self.on);
    visit("torque", self.torque);
    visit("axes", self.axes);
    visit("factor", self.factor);
    visit("reaction", self.reaction);
  }

  void apply(EffortScan& scan) const;
};

}  // namespace borelli
