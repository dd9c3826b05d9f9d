#include "dynamics/system/solid_order.hpp"

#include <fmt/format.h>

#include "error/printable.hpp"

namespace borelli {

std::string solid_list(const Scene& scene) {
  std::vector<std::string> names{world_name};
  for (const Solid& solid : scene.solids) names.push_back(solid.name);
  return name_list(names);
}

Result<SolidOrder> order_solids(const Scene& scene) {
  SolidOrder out;
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    const Solid& solid = scene.solids[i];
    if (solid.name.empty())
      return bad_use(fmt::format("{}solid {}", scene.place(solid.line), i + 1), "has no name; give it one");
    if (solid.name == world_name) return bad_use(scene.where(solid), "has the fixed frame's name; rename it");
    if (!out.number.emplace(solid.name, static_cast<int>(i)).second)
      return bad_use(scene.where(solid), "there are two solids of this name; names must differ");
  }
  enum class Mark : char { none, on_path, placed };
  std::vector<Mark> marks(scene.solids.size(), Mark::none);
  for (std::size_t start = 0; start < scene.solids.size(); ++start) {
    std::vector<int> path;  // the path from the solid up to a placed one
    for (int i = static_cast<int>(start); marks[i] != Mark::placed;) {
      const Solid& solid = scene.solids[i];
      if (marks[i] == Mark::on_path)
        return bad_use(scene.where(solid),
                       fmt::format("is its own ancestor (its parent is '{}'); close loops with constraints",
                                   solid.parent));
      marks[i] = Mark::on_path;
      path.push_back(i);
      if (solid.parent == world_name) break;
      const auto parent = out.number.find(solid.parent);
      if (parent == out.number.end())
        return bad_use(scene.where(solid), fmt::format("its parent '{}' is not in the scene; choose from {}",
                                                       solid.parent, solid_list(scene)));
      i = parent->second;
    }
    for (auto i = path.rbegin(); i != path.rend(); ++i) {
      marks[*i] = Mark::placed;
      out.order.push_back(*i);
    }
  }
  return out;
}

}  // namespace borelli
