// Unilateral constraint: a sphere, or a point, stays above a plane fixed in a solid or in the world.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// n . (c - p_plane) - radius >= 0: one contact, m.
struct SphereOverPlane {
  static constexpr std::string_view kind = "sphere_over_plane";
  SolidPoint sphere;  ///< its centre
  double radius = 0;  ///< m; 0: a point
  Plane plane;
  ContactSurface surface;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("sphere", self.sphere);
    visit("radius", self.radius);
    Plane::fields(self.plane, visit);
    ContactSurface::fields(self.surface, visit);
  }

  std::string complaint() const {
    if (const std::string bad = plane.complaint(); !bad.empty()) return bad;
    return radius >= 0 ? surface.complaint() : "its radius must be 0 or more";
  }

  static constexpr int rows = 3;
  static constexpr int length_rows = 3;
  static constexpr int contact_rows = 3;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { sphere_site, plane_site };
    sphere_over_plane(pass, 0, sphere_site, sphere.point, radius, plane_site, plane);
  }
};

}  // namespace borelli
