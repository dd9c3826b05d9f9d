// A torsional spring and damper between the axes of two solids, or of a solid and the world.
#pragma once

#include <string_view>

#include "dynamics/rotation_vector.hpp"
#include "dynamics/site.hpp"

namespace borelli {

template <class T>
class EffortScan;

/// With R_ba = rotation(rest) rotation(theta), theta the rotation vector (|theta| <= pi) by which a is turned
/// from rest, the torque on a is -stiffness theta - damping (w_a - w_b), and its opposite on b. The spring's
/// part has the potential stiffness |theta|^2 / 2; it jumps where |theta| passes pi.
struct TorsionSpring {
  static constexpr std::string_view kind = "torsion_spring";
  SolidName a, b;
  double stiffness = 0;                            ///< N m/rad
  double damping = 0;                              ///< N m s/rad
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();  ///< rotation vector of a in b at rest, rad, b's axes

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("stiffness", self.stiffness);
    visit("damping", self.damping);
    visit("rest", self.rest);
  }

  template <class T>
  void apply(EffortScan<T>& scan) const {
    enum { a_site, b_site };
    const Eigen::Matrix3<T> R_Wa = scan.frame(a_site).R, R_Wb = scan.frame(b_site).R;
    const Eigen::Vector3<T> theta =  // in a's axes
        logarithm(product(conjugate(exponential(rest)), quaternion(R_Wb.transpose() * R_Wa)));
    const Eigen::Vector3<T> w = scan.angular_velocity(a_site) - scan.angular_velocity(b_site);
    const Eigen::Vector3<T> m = -stiffness * (R_Wa * theta) - damping * w;
    scan.torque(a_site, m);
    scan.torque(b_site, -m);
    scan.potential(0.5 * stiffness * theta.squaredNorm());
    scan.power(-damping * w.squaredNorm());
  }
};

}  // namespace borelli
