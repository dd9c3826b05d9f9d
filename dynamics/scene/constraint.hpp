// Constraints beyond the joints: rows h(q, t) = 0, or rows of velocities L u = 0, held by Lagrange
// multipliers. A new kind is one new file beside constraint_distance.hpp, and its name in the list below.
#pragma once

#include <string>
#include <variant>

#include "dynamics/scene/constraint_angle.hpp"
#include "dynamics/scene/constraint_box_over_plane.hpp"
#include "dynamics/scene/constraint_capsule_over_capsule.hpp"
#include "dynamics/scene/constraint_capsule_over_plane.hpp"
#include "dynamics/scene/constraint_coordinate_coupling.hpp"
#include "dynamics/scene/constraint_coordinate_function.hpp"
#include "dynamics/scene/constraint_distance.hpp"
#include "dynamics/scene/constraint_function.hpp"
#include "dynamics/scene/constraint_knife_edge.hpp"
#include "dynamics/scene/constraint_limit.hpp"
#include "dynamics/scene/constraint_point_on_curve.hpp"
#include "dynamics/scene/constraint_point_on_line.hpp"
#include "dynamics/scene/constraint_point_on_plane.hpp"
#include "dynamics/scene/constraint_point_on_point.hpp"
#include "dynamics/scene/constraint_rolling_disc.hpp"
#include "dynamics/scene/constraint_rolling_sphere.hpp"
#include "dynamics/scene/constraint_rope.hpp"
#include "dynamics/scene/constraint_sphere_over_plane.hpp"
#include "dynamics/scene/constraint_sphere_over_sphere.hpp"
#include "dynamics/scene/constraint_weld.hpp"

namespace borelli {

using ConstraintKind =
    std::variant<PointOnPoint, PointOnLine, PointOnCurve, PointOnPlane, Distance, AngleConstraint,
                 CoordinateCoupling, CoordinateFunction, WeldConstraint, FunctionConstraint, RollingDisc,
                 RollingSphere, KnifeEdge, Limit, Rope, SphereOverPlane, CapsuleOverPlane, BoxOverPlane,
                 SphereOverSphere, CapsuleOverCapsule>;

/// Kinds whose rows are contacts (contact.hpp).
template <class Kind>
concept Unilateral = requires {
  Kind::contact_rows;
};

/// Kinds whose last `kinematic_rows` rows hold velocities alone (nonholonomic: no function of positions has
/// them as its rate): their h is zero everywhere, and projection puts right their velocities only.
template <class Kind>
concept Kinematic = requires {
  Kind::kinematic_rows;
};

/// How many rows a constraint has: `rows`, a constant, or a function where its fields decide.
inline int row_count(const ConstraintKind& kind) {
  return std::visit(
      [](const auto& k) {
        if constexpr (requires { k.rows(); })
          return k.rows();
        else
          return k.rows;
      },
      kind);
}

inline int kinematic_row_count(const ConstraintKind& kind) {
  return std::visit(
      []<class Kind>(const Kind&) {
        if constexpr (Kinematic<Kind>)
          return Kind::kinematic_rows;
        else
          return 0;
      },
      kind);
}

/// The radii of both of what touches, together, m: its gap is a distance less that. 0: of something flat, or
/// a limit.
inline double radii_of(const ConstraintKind& kind) {
  return std::visit(
      [](const auto& k) {
        if constexpr (requires { k.radii; })
          return k.radii.a + k.radii.b;
        else
          return 0.;
      },
      kind);
}

/// The surface of a unilateral constraint.
inline ContactSurface surface_of(const ConstraintKind& kind) {
  return std::visit(
      [](const auto& k) {
        if constexpr (requires { k.surface; })
          return k.surface;
        else if constexpr (requires { k.restitution; })
          return ContactSurface{.restitution = k.restitution};
        else
          return ContactSurface{};
      },
      kind);
}

struct Constraint {
  std::string name;  ///< unique among the scene's constraints; errors and multipliers bear it
  ConstraintKind kind;
  int line = 0;  ///< as Solid::line
};

}  // namespace borelli
