// A named point of a solid that measurements refer to.
#pragma once

#include <string>

#include "dynamics/scene/site.hpp"

namespace borelli {

/// A marker on a solid, or on the world. It has no mass and does not change the motion.
struct Marker {
  std::string name;  ///< unique among the markers of the scene
  SolidPoint at;
  int line = 0;  ///< as Solid::line
};

}  // namespace borelli
