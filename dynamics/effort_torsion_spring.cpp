#include "dynamics/effort_torsion_spring.hpp"

#include "dynamics/rotation_vector.hpp"
#include "dynamics/scan.hpp"

namespace borelli {

void TorsionSpring::apply(EffortScan& scan) const {
  enum { a_site, b_site };
  const Eigen::Matrix3d R_Wa = scan.frame(a_site).R, R_Wb = scan.frame(b_site).R;
  const Eigen::Vector3d theta =  // in a's axes
      logarithm(product(conjugate(exponential(rest)), quaternion(R_Wb.transpose() * R_Wa)));
  const Eigen::Vector3d w = scan.angular_velocity(a_site) - scan.angular_velocity(b_site);
  const Eigen::Vector3d m = -stiffness * (R_Wa * theta) - damping * w;
  scan.torque(a_site, m);
  scan.torque(b_site, -m);
  scan.potential(0.5 * stiffness * theta.squaredNorm());
  scan.power(-damping * w.squaredNorm());
}

}  // namespace borelli
