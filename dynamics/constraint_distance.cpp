#include "dynamics/constraint_distance.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void Distance::evaluate(ConstraintScan& scan) const {
  enum { a_site, b_site };
  const MovingPoint pa = scan.point(a_site, a.point), pb = scan.point(b_site, b.point);
  const Eigen::Vector3d d = pa.p - pb.p, v = pa.v - pb.v;
  const double length = d.norm();
  const TimeValue asked = at(distance, scan.time());
  if (!(length > 1e-12 * std::abs(asked.value)) || length == 0) {
    scan.degenerate(0);
    scan.residual(0, length - asked.value, 0, 0);
    return;
  }
  const Eigen::Vector3d n = d / length;
  scan.along(0, a_site, pa.p, n);
  scan.along(0, b_site, pb.p, -n);
  const double across = v.squaredNorm() - n.dot(v) * n.dot(v);
  scan.residual(0, length - asked.value, -asked.rate, across / length - asked.acceleration);
}

}  // namespace borelli
