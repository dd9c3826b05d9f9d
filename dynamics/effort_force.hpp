// A force at a point of a solid, external or internal (an opposite pair).
#pragma once

#include <optional>
#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

template <class T>
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

  template <class T>
  void apply(EffortScan<T>& scan) const {
    enum { at_site, reaction_site };
    const Eigen::Vector3<T> given = axes == Axes::solid ? Eigen::Vector3<T>(scan.frame(at_site).R * force)
                                                        : Eigen::Vector3<T>(force.cast<T>());
    const Eigen::Vector3<T> f = borelli::at(factor, scan.time()).value * given;
    const auto point = scan.point(at_site, at.point);
    scan.force(at_site, point.p, f);
    scan.power(f.dot(point.v));
    if (!reaction) return;
    const auto other = scan.point(reaction_site, reaction->point);
    scan.force(reaction_site, other.p, -f);
    scan.power(-f.dot(other.v));
  }
};

}  // namespace borelli
