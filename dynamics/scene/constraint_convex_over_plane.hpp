// Unilateral constraint: a convex shape stays above a plane fixed in a solid or in the world.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "dynamics/scene/shape.hpp"
#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

struct Convex;

/// Gaps between a shape of a solid and a plane, m. One contact for a sphere or an ellipsoid, two for a
/// capsule; else eight, at the corners of the surface nearest to the plane. A mesh counts as its convex hull.
/// A contact that this surface does not need has a large gap. Only for time stepping (method `moreau`).
struct ConvexOverPlane {
  static constexpr std::string_view kind = "convex_over_plane";
  SolidName convex;
  Shape shape;
  Plane plane;
  ContactSurface surface;
  std::shared_ptr<const Convex> prepared;  ///< made by prepare()

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("convex", self.convex);
    visit("shape", self.shape);
    Plane::fields(self.plane, visit);
    ContactSurface::fields(self.surface, visit);
  }

  std::string complaint() const;
  void prepare();

  int rows() const;
  static constexpr int length_rows = 24;
  static constexpr int contact_rows = 3;
  static constexpr bool time_stepping = true;

  /// See convex_contact.cpp.
  template <class T>
  void evaluate(ConstraintPass<T>& pass) const;
};

}  // namespace borelli
