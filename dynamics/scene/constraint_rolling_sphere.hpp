// Constraint: a sphere rolls without slip on a plane fixed in a solid or in the world.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// The sphere touches the plane, n . (c - p_plane) - radius = 0 (holonomic, m). Its contact point has the
/// velocity of the plane (two kinematic rows, m/s). It may spin about n. The multipliers are the force of the
/// plane on the sphere: along n, and along two tangents fixed in the plane. The plane can pull as well as
/// push. For lift-off and slip see SphereOverPlane.
struct RollingSphere {
  static constexpr std::string_view kind = "rolling_sphere";
  SolidPoint sphere;  ///< its centre
  double radius = 0;  ///< m
  Plane plane;
  bool held = true;  ///< false: joints fix its height, and the first row is left out

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("sphere", self.sphere);
    visit("radius", self.radius);
    Plane::fields(self.plane, visit);
    visit("held", self.held);
  }

  std::string complaint() const { return radius > 0 ? plane.complaint() : "its radius must be positive"; }

  int rows() const { return held ? 3 : 2; }
  static constexpr int length_rows = 3;
  static constexpr int kinematic_rows = 2;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { sphere_site, plane_site };
    rows_on_plane<T>(pass, 0, sphere_site,
                     sphere_on_plane(pass, sphere_site, sphere.point, radius, plane_site, plane), plane_site,
                     plane, held);
  }
};

}  // namespace borelli
