// A spring and damper between two points: of two solids, or of a solid and the world.
#pragma once

#include <string_view>

#include "dynamics/numbers/scalar.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class EffortPass;

/// Pulls a and b together with stiffness (l - rest_length) + damping dl/dt along the line between them, l
/// their distance. At l = 0 the line has no direction and the force is zero.
struct PointSpring {
  static constexpr std::string_view kind = "point_spring";
  SolidPoint a, b;
  double stiffness = 0;    ///< N/m
  double damping = 0;      ///< N s/m
  double rest_length = 0;  ///< m

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("stiffness", self.stiffness);
    visit("damping", self.damping);
    visit("rest_length", self.rest_length);
  }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { a_site, b_site };
    const auto pa = pass.point(a_site, a.point), pb = pass.point(b_site, b.point);
    const Eigen::Vector3<T> d = pa.p - pb.p;
    using std::sqrt;
    const T length = sqrt(d.squaredNorm()), stretch = length - rest_length;
    pass.potential(0.5 * stiffness * stretch * stretch);
    const Eigen::Vector3<T> n = d * either(
                                        length == 0, [] { return T(0); }, [&] { return T(1 / length); });
    const T rate = n.dot(pa.v - pb.v);
    const Eigen::Vector3<T> f = -(stiffness * stretch + damping * rate) * n;
    pass.force(a_site, pa.p, f);
    pass.force(b_site, pb.p, -f);
    pass.power(-damping * rate * rate);
  }
};

}  // namespace borelli
