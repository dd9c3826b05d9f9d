#include "dynamics/scene/scene.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace borelli {

Result<std::vector<Inertial>> inertials_of(const Solid& solid) {
  std::vector<Inertial> out = solid.inertials;
  for (std::size_t i = 0; i < solid.shapes.size(); ++i) {
    const ShapeElement& element = solid.shapes[i];
    if (!element.density && !element.mass) continue;
    const std::string where = fmt::format("solid '{}', shape {}", solid.name, i + 1);
    if (element.density && element.mass)
      return bad_use(where, "has a density and a mass, expected one of the two");
    const auto inertial = element.density ? inertial_of_density(element.shape, *element.density)
                                          : inertial_of_mass(element.shape, *element.mass);
    if (!inertial) return tl::unexpected(Error{where, inertial.error().message(), inertial.error().kind});
    out.push_back(*inertial);
  }
  return out;
}

std::string coordinate_name(const Solid& solid, std::size_t i) {
  const auto moves = [](const Switch& s) {
    return std::visit([](const auto& kind) { return kind.nv > 0; }, s.kind);
  };
  if (!moves(solid.switches[i])) return {};
  if (!solid.switches[i].coordinate.empty()) return solid.switches[i].coordinate;
  const auto begin = solid.switches.begin();
  if (std::count_if(begin, solid.switches.end(), moves) == 1) return solid.name;
  return fmt::format("{}.{}", solid.name,
                     std::count_if(begin, begin + static_cast<std::ptrdiff_t>(i) + 1, moves));
}

std::string place_in(const std::string& file, int line) {
  if (file.empty()) return {};
  return line > 0 ? fmt::format("{}:{}: ", file, line) : file + ": ";
}

std::string Scene::where(const Solid& solid) const {
  return fmt::format("{}solid '{}'", place(solid.line), solid.name);
}

}  // namespace borelli
