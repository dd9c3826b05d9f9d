// Constraint: a thin disc (coin, wheel) rolls without slip on a plane fixed in a solid or in the world.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// The lowest point of the rim touches the plane: n . (c - p_plane) - radius |n x a| = 0 (holonomic, m; a is
/// the axis of the disc). That point has the velocity of the plane (two kinematic rows, m/s). So the disc
/// rolls, and may lean, turn and spin. The multipliers are the force of the plane on the disc: along n, and
/// along two tangents fixed in the plane. A disc that lies flat is singular.
struct RollingDisc {
  static constexpr std::string_view kind = "rolling_disc";
  SolidPoint disc;                                  ///< its centre
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< in its solid's axes; either sense
  double radius = 0;                                ///< m
  Plane plane;
  bool held = true;  ///< false: joints fix its height, and the first row is left out

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("disc", self.disc);
    visit("axis", self.axis);
    visit("radius", self.radius);
    Plane::fields(self.plane, visit);
    visit("held", self.held);
  }

  std::string complaint() const {
    if (!(axis.norm() > 1e-12)) return "its axis has no direction";
    return radius > 0 ? plane.complaint() : "its radius must be positive";
  }

  int rows() const { return held ? 3 : 2; }
  static constexpr int length_rows = 3;
  static constexpr int kinematic_rows = 2;

  // The lowest point of the rim is c - radius e; e = (n - cosine a) / sine is the upward unit vector in the
  // plane of the disc.
  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { disc_site, plane_site };
    using std::sqrt;
    using Vector = Eigen::Vector3<T>;
    const auto c = pass.point(disc_site, disc.point);
    const Vector n = pass.frame(plane_site).R * plane.normal, a = pass.frame(disc_site).R * axis;
    const Vector n_rate = pass.angular_velocity(plane_site).cross(n),
                 a_rate = pass.angular_velocity(disc_site).cross(a);
    const T cosine = n.dot(a), cosine_rate = n_rate.dot(a) + n.dot(a_rate);
    const Vector up = n - cosine * a;
    const T sine = sqrt(up.squaredNorm());
    if (!(value_of(sine) > 1e-9)) {
      pass.degenerate(0);
      return;
    }
    const Vector e = up / sine;
    const Vector e_rate =
        (n_rate - cosine_rate * a - cosine * a_rate + cosine * cosine_rate / sine * e) / sine;
    const T height = n.dot(c.p - pass.point(plane_site, plane.on.point).p);
    rows_on_plane<T>(pass, 0, disc_site, {c.p - radius * e, c.v - radius * e_rate, height - radius * sine},
                     plane_site, plane, held);
  }
};

}  // namespace borelli
