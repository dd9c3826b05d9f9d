// A torsional spring and damper between the axes of two solids, or of a solid and the world.
#pragma once

#include <string_view>

#include "dynamics/site.hpp"

namespace borelli {

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

  void apply(EffortScan& scan) const;
};

}  // namespace borelli
