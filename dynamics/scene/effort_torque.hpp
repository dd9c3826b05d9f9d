// A torque on a solid, external or internal (an opposite pair).
#pragma once

#include <optional>
#include <string_view>

#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class EffortPass;

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

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { on_site, reaction_site };
    const Eigen::Vector3<T> given = axes == Axes::solid ? Eigen::Vector3<T>(pass.frame(on_site).R * torque)
                                                        : Eigen::Vector3<T>(torque.cast<T>());
    const Eigen::Vector3<T> m = at(factor, pass.time()).value * given;
    pass.torque(on_site, m);
    pass.power(m.dot(pass.angular_velocity(on_site)));
    if (!reaction) return;
    pass.torque(reaction_site, -m);
    pass.power(-m.dot(pass.angular_velocity(reaction_site)));
  }
};

}  // namespace borelli
