// Unilateral constraint: two spheres do not overlap.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// |c_a - c_b| - radius_a - radius_b >= 0: one contact, m.
struct SphereOverSphere {
  static constexpr std::string_view kind = "sphere_over_sphere";
  SolidPoint a, b;  ///< centres
  Radii radii;
  ContactSurface surface;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    Radii::fields(self.radii, visit);
    ContactSurface::fields(self.surface, visit);
  }

  std::string complaint() const {
    const std::string bad = radii.complaint();
    return bad.empty() ? surface.complaint() : bad;
  }

  static constexpr int rows = 3;
  static constexpr int length_rows = 3;
  static constexpr int contact_rows = 3;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { a_site, b_site };
    capsule_over_capsule<T>(pass, 0, a_site, {.centre = a.point, .radius = radii.a}, b_site,
                            {.centre = b.point, .radius = radii.b});
  }
};

}  // namespace borelli
