// Holonomic constraint: a point stays on a plane fixed in a solid or in the world; the plane may move in
// time.
#pragma once

#include <string_view>

#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/plane.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// Row r: n . (p - p_plane) - shift, m, for a point of solid a and a plane of solid b, each given in the
/// frame of its solid.
// Relative to the solid of the plane, the point moves with v_rel = v_point - v_plane(p); v_plane(p) is the
// velocity of the point of that solid at p. The second derivative of h is n . (a_point - a_plane(p)) - 2 n .
// (w x v_rel) - shift'': relative acceleration less the Coriolis term.
template <class T>
void point_on_plane_row(ConstraintPass<T>& pass, int r, int a, const Eigen::Vector3d& point, int b,
                        const Eigen::Vector3d& on, const Eigen::Vector3d& normal, const TimeValue& shift) {
  const auto p = pass.point(a, point);
  const Eigen::Vector3<T> n = pass.frame(b).R * normal;
  const Eigen::Vector3<T> v_rel = p.v - pass.velocity(b, p.p);
  pass.along(r, a, p.p, n);
  pass.along(r, b, p.p, -n);
  pass.residual(r, n.dot(p.p - pass.point(b, on).p) - shift.value, -shift.rate,
                -2 * n.dot(pass.angular_velocity(b).cross(v_rel)) - shift.acceleration);
}

/// n . (p - p_plane) - offset(t) = 0: one row, m.
struct PointOnPlane {
  static constexpr std::string_view kind = "point_on_plane";
  SolidPoint point;
  Plane plane;
  TimeFunction offset = constant(0);  ///< m, along the normal

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("point", self.point);
    Plane::fields(self.plane, visit);
    visit("offset", self.offset);
  }

  std::string complaint() const { return plane.complaint(); }

  static constexpr int rows = 1;
  static constexpr int length_rows = 1;  ///< number of leading rows in m

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { point_site, plane_site };
    point_on_plane_row(pass, 0, point_site, point.point, plane_site, plane.on.point, plane.normal,
                       at(offset, pass.time()));
  }
};

}  // namespace borelli
