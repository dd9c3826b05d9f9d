// A force at a point of a solid, external or internal (an opposite pair).
#pragma once

#include <optional>
#include <string_view>

#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class EffortPass;

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

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { at_site, reaction_site };
    const Eigen::Vector3<T> given = axes == Axes::solid ? Eigen::Vector3<T>(pass.frame(at_site).R * force)
                                                        : Eigen::Vector3<T>(force.cast<T>());
    const Eigen::Vector3<T> f = borelli::at(factor, pass.time()).value * given;
    const auto point = pass.point(at_site, at.point);
    pass.force(at_site, point.p, f);
    pass.power(f.dot(point.v));
    if (!reaction) return;
    const auto other = pass.point(reaction_site, reaction->point);
    pass.force(reaction_site, other.p, -f);
    pass.power(-f.dot(other.v));
  }
};

}  // namespace borelli
