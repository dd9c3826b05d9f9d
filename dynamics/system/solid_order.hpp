// The order in which the solids of a scene are compiled: parents before their children.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

struct SolidOrder {
  std::map<std::string, int> number;  ///< index in Scene::solids, by name
  std::vector<int> order;  ///< these indices, parents before children, otherwise in the scene's order
};

/// Errors name the solid: an empty name, the name of the world, a duplicate name, an unknown parent, a cycle
/// of parents.
Result<SolidOrder> order_solids(const Scene& scene);

/// The names of all solids, for errors: "world, pelvis, thigh".
std::string solid_list(const Scene& scene);

}  // namespace borelli
