// The solids of a scene in the order that it is compiled in: parents before their children.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

struct SolidOrder {
  std::map<std::string, int> number;  ///< of each solid in Scene::solids, by its name
  std::vector<int> order;             ///< those numbers, parents before children, else the scene's own order
};

/// Fails, with the solid's name, where one has none, or the world's, or another's, where its parent is not
/// there, and where parents run in a circle.
Result<SolidOrder> order_solids(const Scene& scene);

/// The names that may stand for a solid, for errors: "world, pelvis, thigh".
std::string solid_list(const Scene& scene);

}  // namespace borelli
