// Unilateral constraint: a capsule stays above a plane fixed in a solid or in the world.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// The two end spheres stay above the plane: two contacts of three rows, m.
struct CapsuleOverPlane {
  static constexpr std::string_view kind = "capsule_over_plane";
  SolidPoint capsule;                               ///< its centre
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< in its solid's axes; made unit by compile()
  double length = 1, radius = 0.1;                  ///< m; length of the cylinder without caps
  Plane plane;
  ContactSurface surface;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("capsule", self.capsule);
    visit("axis", self.axis);
    visit("length", self.length);
    visit("radius", self.radius);
    Plane::fields(self.plane, visit);
    ContactSurface::fields(self.surface, visit);
  }

  std::string complaint() const {
    if (const std::string bad = plane.complaint(); !bad.empty()) return bad;
    if (!(axis.norm() > 1e-12)) return "its axis has no direction";
    if (!(length > 0 && radius >= 0)) return "its length must be positive and its radius 0 or more";
    return surface.complaint();
  }

  static constexpr int rows = 6;
  static constexpr int length_rows = 6;
  static constexpr int contact_rows = 3;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { capsule_site, plane_site };
    for (int end = 0; end < 2; ++end)
      sphere_over_plane<T>(pass, 3 * end, capsule_site,
                           capsule.point + (end == 0 ? 0.5 : -0.5) * length * axis, radius, plane_site,
                           plane);
  }
};

}  // namespace borelli
