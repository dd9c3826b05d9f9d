// Constraints beyond the joints: rows h(q, t) = 0, held by Lagrange multipliers. A new kind is one new file
// pair beside constraint_distance.hpp, and its name in the list below.
#pragma once

#include <string>
#include <variant>

#include "dynamics/constraint_box_over_plane.hpp"
#include "dynamics/constraint_capsule_over_capsule.hpp"
#include "dynamics/constraint_capsule_over_plane.hpp"
#include "dynamics/constraint_coordinate_coupling.hpp"
#include "dynamics/constraint_distance.hpp"
#include "dynamics/constraint_function.hpp"
#include "dynamics/constraint_limit.hpp"
#include "dynamics/constraint_point_on_plane.hpp"
#include "dynamics/constraint_point_on_point.hpp"
#include "dynamics/constraint_rope.hpp"
#include "dynamics/constraint_sphere_over_plane.hpp"
#include "dynamics/constraint_sphere_over_sphere.hpp"
#include "dynamics/constraint_weld.hpp"

namespace borelli {

using ConstraintKind = std::variant<PointOnPoint, PointOnPlane, Distance, CoordinateCoupling, WeldConstraint,
                                    FunctionConstraint, Limit, Rope, SphereOverPlane, CapsuleOverPlane,
                                    BoxOverPlane, SphereOverSphere, CapsuleOverCapsule>;

/// Kinds whose rows are contacts (contact.hpp).
template <class Kind>
concept Unilateral = requires {
  Kind::contact_rows;
};

/// The surface of a unilateral constraint.
inline ContactSurface surface_of(const ConstraintKind& kind) {
  return std::visit(
      [](const auto& k) {
        ContactSurface surface;
        if constexpr (requires { k.restitution; }) surface.restitution = k.restitution;
        if constexpr (requires { k.friction; }) surface.friction = k.friction;
        return surface;
      },
      kind);
}

struct Constraint {
  std::string name;  ///< unique among the scene's constraints; errors and multipliers bear it
  ConstraintKind kind;
  int line = 0;  ///< as Solid::line
};

}  // namespace borelli
