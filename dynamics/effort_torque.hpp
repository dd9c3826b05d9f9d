// A torque on a solid, external or internal (an opposite pair).
#pragma once

#include <optional>
#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

template <class T>
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

  template <class T>
  void apply(EffortScan<T>& scan) const {
    enum { on_site, reaction_site };
    const Eigen::Vector3<T> given = axes == Axes::solid ? Eigen::Vector3<T>(scan.frame(on_site).R * torque)
                                                        : Eigen::Vector3<T>(torque.cast<T>());
    const Eigen::Vector3<T> m = at(factor, scan.time()).value * given;
    scan.torque(on_site, m);
    scan.power(m.dot(scan.angular_velocity(on_site)));
    if (!reaction) return;
    scan.torque(reaction_site, -m);
    scan.power(-m.dot(scan.angular_velocity(reaction_site)));
  }
};

}  // namespace borelli
