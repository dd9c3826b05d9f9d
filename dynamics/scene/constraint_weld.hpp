// Holonomic constraint: a solid keeps its pose in another solid or in the world (closes a rigid loop). Solids
// joined by fixed switches in the tree need none: compile() merges them.
#pragma once

#include <string_view>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// X_ba = `pose`: six rows. The first three are position (world axes, m). The last three are rotation: twice
/// the vector part of the quaternion of pose.R^T R_ba (axes of a, rad to first order), which vanishes at no
/// other orientation.
struct WeldConstraint {
  static constexpr std::string_view kind = "weld";
  SolidName a, b;
  Pose pose;  ///< of a in b

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("pose", self.pose);
  }

  static constexpr int rows = 6;
  static constexpr int length_rows = 3;  ///< number of leading rows in m

  // Rotation: (s, e) is the unit quaternion of pose.R^T R_ba, w the angular velocity of a in b, in the axes
  // of a. h = 2 e has the rate M w, M = s 1 + [e]x, and M' w = ((e x w) x w - (e . w) w) / 2.
  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { a_site, b_site };
    const PoseOf<T> X_a = pass.frame(a_site), X_b = pass.frame(b_site);
    const Eigen::Vector3<T> place = X_b * pose.p;
    for (int r = 0; r < 3; ++r) {
      const Eigen::Vector3<T> axis = Eigen::Vector3<T>::Unit(r);
      pass.along(r, a_site, X_a.p, axis);
      pass.along(r, b_site, place, -axis);
      pass.residual(r, X_a.p[r] - place[r], 0, 0);
    }
    const QuaternionOf<T> error = quaternion(pose.R.transpose() * (X_b.R.transpose() * X_a.R));
    const Eigen::Vector3<T> e = error.template tail<3>();
    const Eigen::Vector3<T> w_a = pass.angular_velocity(a_site), w_b = pass.angular_velocity(b_site);
    const Eigen::Vector3<T> w = X_a.R.transpose() * (w_a - w_b);
    Eigen::Matrix3<T> M;
    M << error[0], -e[2], e[1], e[2], error[0], -e[0], -e[1], e[0], error[0];
    const Eigen::Vector3<T> bias =
        M * (X_a.R.transpose() * w_a.cross(w_b)) + 0.5 * (e.cross(w).cross(w) - e.dot(w) * w);
    for (int r = 0; r < 3; ++r) {
      const Eigen::Vector3<T> m = X_a.R * M.row(r).transpose();
      pass.about(3 + r, a_site, m);
      pass.about(3 + r, b_site, -m);
      pass.residual(3 + r, 2 * e[r], 0, bias[r]);
    }
  }
};

}  // namespace borelli
