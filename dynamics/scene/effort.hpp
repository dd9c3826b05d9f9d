// Efforts (the paper's strains): what acts on the solids beside their weight and what holds the joints. A new
// kind is one new header beside effort_force.hpp, and its name in the list below.
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
  std::string name;  ///< unique among the scene's efforts; errors name it
  EffortKind kind;
  int line = 0;  ///< as Solid::line
};

}  // namespace borelli
