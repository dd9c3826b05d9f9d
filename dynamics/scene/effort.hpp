// Efforts (the paper's strains): forces and torques on the solids other than weight and joint reactions. To
// add a kind, write a header like effort_force.hpp and list its name below.
#pragma once

#include <string>
#include <variant>

#include "dynamics/scene/effort_coordinate_spring.hpp"
#include "dynamics/scene/effort_drag.hpp"
#include "dynamics/scene/effort_force.hpp"
#include "dynamics/scene/effort_limit_spring.hpp"
#include "dynamics/scene/effort_own.hpp"
#include "dynamics/scene/effort_pd_controller.hpp"
#include "dynamics/scene/effort_point_spring.hpp"
#include "dynamics/scene/effort_torque.hpp"
#include "dynamics/scene/effort_torsion_spring.hpp"

namespace borelli {

using EffortKind = std::variant<Force, Torque, PointSpring, TorsionSpring, CoordinateSpring, LimitSpring,
                                PdController, Drag, AngularDrag, OwnEffort>;

struct Effort {
  std::string name;  ///< unique among the efforts of the scene; used in errors
  EffortKind kind;
  int line = 0;  ///< as Solid::line
};

}  // namespace borelli
