// A torsional spring and damper between the orientations of two solids, or of a solid and the world.
#pragma once

#include <string_view>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class EffortPass;

/// R_ba = rotation(rest) rotation(theta), with theta the rotation vector (|theta| <= pi) of a from rest. The
/// torque on a is -stiffness theta - damping (w_a - w_b), and its opposite acts on b. The elastic part has
/// the potential stiffness |theta|^2 / 2. Its torque reverses where |theta| passes pi (an event:
/// spring_events.hpp).
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

  /// The rotation of a in b from rest, in the axes of a, as a quaternion.
  template <class Reader>
  auto turned(const Reader& reader) const {
    enum { a_site, b_site };
    return product(conjugate(exponential(rest)),
                   quaternion(reader.frame(b_site).R.transpose() * reader.frame(a_site).R));
  }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    enum { a_site, b_site };
    const Eigen::Matrix3<T> R_Wa = pass.frame(a_site).R;
    const Eigen::Vector3<T> theta = logarithm(turned(pass));
    const Eigen::Vector3<T> w = pass.angular_velocity(a_site) - pass.angular_velocity(b_site);
    const Eigen::Vector3<T> m = -stiffness * (R_Wa * theta) - damping * w;
    pass.torque(a_site, m);
    pass.torque(b_site, -m);
    pass.potential(0.5 * stiffness * theta.squaredNorm());
    pass.power(-damping * w.squaredNorm());
  }
};

}  // namespace borelli
