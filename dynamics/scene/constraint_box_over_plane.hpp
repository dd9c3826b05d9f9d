// Unilateral constraint: a box stays above a plane fixed in a solid or in the world.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// The eight corners stay above the plane: eight contacts of three rows, m. The edges are parallel to the
/// axes of the solid. Corner k is on the side of +x if bit 0 of k is set, of +y for bit 1, of +z for bit 2.
struct BoxOverPlane {
  static constexpr std::string_view kind = "box_over_plane";
  SolidPoint box;                                  ///< its centre
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< full edge lengths, m
  Plane plane;
  ContactSurface surface;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("box", self.box);
    visit("size", self.size);
    Plane::fields(self.plane, visit);
    ContactSurface::fields(self.surface, visit);
  }

  std::string complaint() const {
    if (const std::string bad = plane.complaint(); !bad.empty()) return bad;
    if (!(size.minCoeff() > 0)) return "its edges must be positive";
    return surface.complaint();
  }

  static constexpr int rows = 24;
  static constexpr int length_rows = 24;
  static constexpr int contact_rows = 3;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { box_site, plane_site };
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d side(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5);
      sphere_over_plane<T>(pass, 3 * k, box_site, box.point + side.cwiseProduct(size), 0, plane_site, plane);
    }
  }
};

}  // namespace borelli
