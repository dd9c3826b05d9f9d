// Holonomic constraint: prescribes the angle between two directions, each fixed in a solid or in the world.
// The angle may be a function of time. (The angle to a plane is pi/2 minus the angle to its normal.)
#pragma once

#include <string_view>

#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// The angle between a and b, in (0, pi), minus angle(t): one row, rad. The row is singular where the
/// directions become parallel. To keep them parallel, use a `weld`, or right angles to two other directions.
struct AngleConstraint {
  static constexpr std::string_view kind = "angle";
  SolidName a;
  Eigen::Vector3d axis_a = Eigen::Vector3d::UnitZ();  ///< in the axes of solid a
  SolidName b;
  Eigen::Vector3d axis_b = Eigen::Vector3d::UnitZ();
  TimeFunction angle = constant(0);  ///< rad

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("axis_a", self.axis_a);
    visit("b", self.b);
    visit("axis_b", self.axis_b);
    visit("angle", self.angle);
  }

  std::string complaint() const {
    if (!(axis_a.norm() > 1e-12 && axis_b.norm() > 1e-12)) return "one of its axes has no direction";
    const double start = at(angle, 0).value;
    return start > 0 && start < M_PI ? "" : "its angle must lie between 0 and pi, both excluded";
  }

  static constexpr int rows = 1;
  static constexpr int length_rows = 0;

  // The rate of the angle is m . (w_a - w_b), with m the unit vector along b x a.
  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { a_site, b_site };
    using std::atan2;
    using std::sqrt;
    using Vector = Eigen::Vector3<T>;
    const Vector a_W = pass.frame(a_site).R * axis_a, b_W = pass.frame(b_site).R * axis_b;
    const Vector w_a = pass.angular_velocity(a_site), w_b = pass.angular_velocity(b_site);
    const Vector c = b_W.cross(a_W), c_rate = w_b.cross(b_W).cross(a_W) + b_W.cross(w_a.cross(a_W));
    const T sine = sqrt(c.squaredNorm());
    if (!(value_of(sine) > 1e-9)) {
      pass.degenerate(0);
      return;
    }
    const Vector m = c / sine, m_rate = (c_rate - m.dot(c_rate) * m) / sine;
    const TimeValue asked = at(angle, pass.time());
    pass.about(0, a_site, m);
    pass.about(0, b_site, -m);
    pass.residual(0, atan2(sine, a_W.dot(b_W)) - asked.value, T(-asked.rate),
                  m_rate.dot(w_a - w_b) - asked.acceleration);
  }
};

}  // namespace borelli
