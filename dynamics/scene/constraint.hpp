// Constraints beyond the joints: rows h(q, t) = 0, or velocity rows L u = 0, enforced by Lagrange
// multipliers. To add a kind, write a file like constraint_distance.hpp and list its name below.
#pragma once

#include <string>
#include <variant>

#include "dynamics/scene/constraint_angle.hpp"
#include "dynamics/scene/constraint_box_over_plane.hpp"
#include "dynamics/scene/constraint_capsule_over_capsule.hpp"
#include "dynamics/scene/constraint_capsule_over_plane.hpp"
#include "dynamics/scene/constraint_convex_over_convex.hpp"
#include "dynamics/scene/constraint_convex_over_plane.hpp"
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
                 SphereOverSphere, CapsuleOverCapsule, ConvexOverPlane, ConvexOverConvex>;

/// Kinds whose rows are unilateral contacts (contact.hpp).
template <class Kind>
concept Unilateral = requires {
  Kind::contact_rows;
};

/// Contacts whose rows hold only within a step of time stepping: they have no accelerations between events.
template <class Kind>
concept TimeStepping = requires {
  Kind::time_stepping;
};

/// Kinds whose last `kinematic_rows` rows are nonholonomic: they constrain velocities only, and no function
/// of positions has them as its rate. Their h is zero everywhere; projection corrects their velocities only.
template <class Kind>
concept Kinematic = requires {
  Kind::kinematic_rows;
};

/// Number of rows: the constant `rows`, or the function rows() if it depends on the fields.
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

/// Sum of the two radii of touching spheres or capsules, m: their gap is a distance minus this sum. Of convex
/// shapes, the sum of the radii of their inscribed spheres. 0 for kinds without two radii.
inline double radii_of(const ConstraintKind& kind) {
  return std::visit(
      [](const auto& k) {
        if constexpr (requires { k.radii; })
          return k.radii.a + k.radii.b;
        else if constexpr (requires { k.inscribed(); })
          return k.inscribed();
        else
          return 0.;
      },
      kind);
}

/// Restitution and friction of a unilateral constraint.
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
  std::string name;  ///< unique among the constraints of the scene; used in errors and for multipliers
  ConstraintKind kind;
  int line = 0;  ///< as Solid::line
};

}  // namespace borelli
