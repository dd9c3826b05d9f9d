// Unilateral constraint: a sphere, or a point, stays above a plane fixed in a solid or in the world.
#pragma once

#include <string_view>

#include "dynamics/surface_contact.hpp"

namespace borelli {

/// n . (c - p_plane) - radius >= 0: one contact, m. n is made unit by compile().
struct SphereOverPlane {
  static constexpr std::string_view kind = "sphere_over_plane";
  SolidPoint sphere;                                  ///< its centre
  double radius = 0;                                  ///< m; 0: a point
  SolidPoint plane;                                   ///< a point of the plane, in the solid that carries it
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< out of the matter, in that solid's axes
  double restitution = 0, friction = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("sphere", self.sphere);
    visit("radius", self.radius);
    visit("plane", self.plane);
    visit("normal", self.normal);
    visit("restitution", self.restitution);
    visit("friction", self.friction);
  }

  std::string complaint() const {
    if (!(normal.norm() > 1e-12)) return "its plane's normal has no direction";
    return radius >= 0 ? complaint_of({restitution, friction}) : "its radius must be 0 or more";
  }

  static constexpr int rows = 3;
  static constexpr int length_rows = 3;
  static constexpr int contact_rows = 3;

  template <class T>
  void evaluate(ConstraintScan<T>& scan) const {
    enum { sphere_site, plane_site };
    sphere_over_plane(scan, 0, sphere_site, sphere.point, radius, plane_site, plane.point, normal);
  }
};

}  // namespace borelli
