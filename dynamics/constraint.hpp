// Constraints beyond the joints: rows h(q, t) = 0, held by Lagrange multipliers. A new kind is one new file
// pair beside constraint_distance.hpp, and its name in the list below.
#pragma once

#include <string>
#include <variant>

#include "dynamics/constraint_coordinate_coupling.hpp"
#include "dynamics/constraint_distance.hpp"
#include "dynamics/constraint_function.hpp"
#include "dynamics/constraint_point_on_plane.hpp"
#include "dynamics/constraint_point_on_point.hpp"
#include "dynamics/constraint_weld.hpp"

namespace borelli {

using ConstraintKind = std::variant<PointOnPoint, PointOnPlane, Distance, CoordinateCoupling, WeldConstraint,
                                    FunctionConstraint>;

struct Constraint {
  std::string name;  ///< unique among the scene's constraints; errors and multipliers bear it
  ConstraintKind kind;
  int line = 0;  ///< as Solid::line
};

}  // namespace borelli
