#include "dynamics/constraint_weld.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

// Rotation: with the unit quaternion (s, e) of pose.R^T R_ba and w the angular velocity of a in b in a's
// axes, h = 2 e has the rate M w, M = s 1 + [e]x, and M' w = ((e x w) x w - (e . w) w) / 2.
void WeldConstraint::evaluate(ConstraintScan& scan) const {
  enum { a_site, b_site };
  const Pose X_a = scan.frame(a_site), X_b = scan.frame(b_site);
  const Eigen::Vector3d place = X_b * pose.p;
  for (int r = 0; r < 3; ++r) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(r);
    scan.along(r, a_site, X_a.p, axis);
    scan.along(r, b_site, place, -axis);
    scan.residual(r, X_a.p[r] - place[r], 0, 0);
  }
  const Quaternion error = quaternion(pose.R.transpose() * (X_b.R.transpose() * X_a.R));
  const Eigen::Vector3d e = error.tail<3>();
  const Eigen::Vector3d w_a = scan.angular_velocity(a_site), w_b = scan.angular_velocity(b_site);
  const Eigen::Vector3d w = X_a.R.transpose() * (w_a - w_b);
  Eigen::Matrix3d M;
  M << error[0], -e[2], e[1], e[2], error[0], -e[0], -e[1], e[0], error[0];
  const Eigen::Vector3d bias =
      M * (X_a.R.transpose() * w_a.cross(w_b)) + 0.5 * (e.cross(w).cross(w) - e.dot(w) * w);
  for (int r = 0; r < 3; ++r) {
    const Eigen::Vector3d m = X_a.R * M.row(r).transpose();
    scan.about(3 + r, a_site, m);
    scan.about(3 + r, b_site, -m);
    scan.residual(3 + r, 2 * e[r], 0, bias[r]);
  }
}

}  // namespace borelli
