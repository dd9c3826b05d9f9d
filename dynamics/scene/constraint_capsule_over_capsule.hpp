// Unilateral constraint: two capsules, or a capsule and a sphere, do not overlap.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// Distance between the two axis segments - radius_a - radius_b >= 0: one contact at the nearest points, m.
/// Parallel capsules side by side touch along a line, but get one contact point only, at the middle of a.
struct CapsuleOverCapsule {
  static constexpr std::string_view kind = "capsule_over_capsule";
  SolidPoint a, b;  ///< centres
  Eigen::Vector3d axis_a = Eigen::Vector3d::UnitZ(),
                  axis_b = Eigen::Vector3d::UnitZ();  ///< in the axes of their solids
  double length_a = 0, length_b = 0;                  ///< m, of the cylinder without caps; 0: a sphere
  Radii radii;
  ContactSurface surface;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("axis_a", self.axis_a);
    visit("axis_b", self.axis_b);
    visit("length_a", self.length_a);
    visit("length_b", self.length_b);
    Radii::fields(self.radii, visit);
    ContactSurface::fields(self.surface, visit);
  }

  std::string complaint() const {
    if (!(axis_a.norm() > 1e-12 && axis_b.norm() > 1e-12)) return "one of its axes has no direction";
    if (!(length_a >= 0 && length_b >= 0)) return "its lengths must be 0 or more";
    const std::string bad = radii.complaint();
    return bad.empty() ? surface.complaint() : bad;
  }

  static constexpr int rows = 3;
  static constexpr int length_rows = 3;
  static constexpr int contact_rows = 3;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { a_site, b_site };
    capsule_over_capsule<T>(pass, 0, a_site, {a.point, axis_a, length_a, radii.a}, b_site,
                            {b.point, axis_b, length_b, radii.b});
  }
};

}  // namespace borelli
