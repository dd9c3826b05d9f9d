#include "dynamics/constraint_point_on_plane.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

// Seen from the plane's solid, the point moves with v_rel = v_point - v_plane(p), v_plane(p) the velocity of
// the solid's own point there; the second derivative of h holds the relative acceleration, less Coriolis'
// part.
void PointOnPlane::evaluate(ConstraintScan& scan) const {
  enum { point_site, plane_site };
  const MovingPoint p = scan.point(point_site, point.point);
  const Eigen::Vector3d n = scan.frame(plane_site).R * normal;
  const TimeValue shift = at(offset, scan.time());
  const Eigen::Vector3d v_rel = p.v - scan.velocity(plane_site, p.p);
  scan.along(0, point_site, p.p, n);
  scan.along(0, plane_site, p.p, -n);
  scan.residual(0, n.dot(p.p - scan.point(plane_site, plane.point).p) - shift.value, -shift.rate,
                -2 * n.dot(scan.angular_velocity(plane_site).cross(v_rel)) - shift.acceleration);
}

}  // namespace borelli
