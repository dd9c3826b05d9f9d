#include "dynamics/constraint_point_on_point.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void PointOnPoint::evaluate(ConstraintScan& scan) const {
  enum { a_site, b_site };
  const Eigen::Vector3d pa = scan.point(a_site, a.point).p, pb = scan.point(b_site, b.point).p;
  for (int r = 0; r < 3; ++r) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(r);
    scan.along(r, a_site, pa, axis);
    scan.along(r, b_site, pb, -axis);
    scan.residual(r, pa[r] - pb[r], 0, 0);
  }
}

}  // namespace borelli
