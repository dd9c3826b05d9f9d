// Drag of a medium at rest in the world on a moving solid.
#pragma once

#include <string>
#include <string_view>

#include "dynamics/numbers/scalar.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class EffortPass;

/// Why the drag coefficients are invalid; empty: they are valid.
inline std::string drag_complaint(double linear, double quadratic) {
  if (linear >= 0 && quadratic >= 0) return "";
  return "its coefficients linear and quadratic must not be negative";
}

/// The force -(linear + quadratic |v|) v at a point that moves at v in the world. A body of frontal area S
/// and drag coefficient C in a fluid of density rho has quadratic = rho C S / 2. A sphere of radius r in
/// creeping flow of viscosity mu has linear = 6 pi mu r (Stokes).
struct Drag {
  static constexpr std::string_view kind = "drag";
  static constexpr bool leans_on_world = true;
  SolidPoint at;
  double linear = 0;     ///< N s/m
  double quadratic = 0;  ///< N s^2/m^2

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("at", self.at);
    visit("linear", self.linear);
    visit("quadratic", self.quadratic);
  }

  std::string complaint() const { return drag_complaint(linear, quadratic); }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { at_site };
    using std::sqrt;
    const auto point = pass.point(at_site, at.point);
    const T resistance = linear + quadratic * sqrt(point.v.squaredNorm());
    pass.force(at_site, point.p, -resistance * point.v);
    pass.power(-resistance * point.v.squaredNorm());
  }
};

/// The torque -(linear + quadratic |w|) w on a solid of angular velocity w in the world.
struct AngularDrag {
  static constexpr std::string_view kind = "angular_drag";
  static constexpr bool leans_on_world = true;
  SolidName on;
  double linear = 0;     ///< N m s
  double quadratic = 0;  ///< N m s^2

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("on", self.on);
    visit("linear", self.linear);
    visit("quadratic", self.quadratic);
  }

  std::string complaint() const { return drag_complaint(linear, quadratic); }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { on_site };
    using std::sqrt;
    const Eigen::Vector3<T> w = pass.angular_velocity(on_site);
    const T resistance = linear + quadratic * sqrt(w.squaredNorm());
    pass.torque(on_site, -resistance * w);
    pass.power(-resistance * w.squaredNorm());
  }
};

}  // namespace borelli
