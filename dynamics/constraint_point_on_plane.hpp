// Holonomic constraint: a point stays on a plane fixed in a solid or in the world; the plane may move in
// time.
#pragma once

#include <string_view>

#include "dynamics/plane.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

template <class T>
class ConstraintScan;

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
  static constexpr int length_rows = 1;  ///< the first ones, which are in m

  // Seen from the plane's solid, the point moves with v_rel = v_point - v_plane(p), v_plane(p) the velocity
  // of the solid's own point there; the second derivative of h holds the relative acceleration, less
  // Coriolis' part.
  template <class T>
  void evaluate(ConstraintScan<T>& scan) const {
    enum { point_site, plane_site };
    const auto p = scan.point(point_site, point.point);
    const Eigen::Vector3<T> n = scan.frame(plane_site).R * plane.normal;
    const TimeValue shift = at(offset, scan.time());
    const Eigen::Vector3<T> v_rel = p.v - scan.velocity(plane_site, p.p);
    scan.along(0, point_site, p.p, n);
    scan.along(0, plane_site, p.p, -n);
    scan.residual(0, n.dot(p.p - scan.point(plane_site, plane.on.point).p) - shift.value, -shift.rate,
                  -2 * n.dot(scan.angular_velocity(plane_site).cross(v_rel)) - shift.acceleration);
  }
};

}  // namespace borelli
