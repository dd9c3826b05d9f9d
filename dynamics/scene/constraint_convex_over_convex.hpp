// Unilateral constraint: two convex shapes do not overlap.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "dynamics/scene/shape.hpp"
#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

struct Convex;

/// Gaps between two shapes, each placed in its solid, m. One contact if either is a sphere or an ellipsoid,
/// two if either is a capsule; else eight, at the corners of the surface where they touch. A mesh counts as
/// its convex hull. A contact that this surface does not need has a large gap. Only for time stepping (method
/// `moreau`).
struct ConvexOverConvex {
  static constexpr std::string_view kind = "convex_over_convex";
  SolidName a, b;
  Shape shape_a, shape_b;
  ContactSurface surface;
  std::shared_ptr<const Convex> convex_a, convex_b;  ///< made by prepare()

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("shape_a", self.shape_a);
    visit("b", self.b);
    visit("shape_b", self.shape_b);
    ContactSurface::fields(self.surface, visit);
  }

  std::string complaint() const;
  void prepare();
  /// Sum of the radii of the inscribed spheres, m.
  double inscribed() const;

  int rows() const;
  static constexpr int length_rows = 24;
  static constexpr int contact_rows = 3;
  static constexpr bool time_stepping = true;

  /// See convex_contact.cpp.
  template <class T>
  void evaluate(ConstraintPass<T>& pass) const;
};

}  // namespace borelli
