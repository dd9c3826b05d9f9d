#include "dynamics/effort_point_spring.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void PointSpring::apply(EffortScan& scan) const {
  enum { a_site, b_site };
  const MovingPoint pa = scan.point(a_site, a.point), pb = scan.point(b_site, b.point);
  const Eigen::Vector3d d = pa.p - pb.p;
  const double length = d.norm(), stretch = length - rest_length;
  scan.potential(0.5 * stiffness * stretch * stretch);
  if (length == 0) return;
  const Eigen::Vector3d n = d / length;
  const double rate = n.dot(pa.v - pb.v);
  const Eigen::Vector3d f = -(stiffness * stretch + damping * rate) * n;
  scan.force(a_site, pa.p, f);
  scan.force(b_site, pb.p, -f);
  scan.power(-damping * rate * rate);
}

}  // namespace borelli
