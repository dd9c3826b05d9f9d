#include "dynamics/formats/osim_write_names.hpp"

#include <fmt/core.h>

namespace borelli {
namespace {

std::string allowed_by_osim(std::string name) {
  for (char& c : name)
    if (std::string_view("/\\*+ \t\n\r").find(c) != std::string_view::npos) c = '_';
  return name.empty() ? "unnamed" : name;
}

bool is_scalar_switch(const Switch& one) {
  return std::visit([](const auto& kind) { return kind.nv == 1; }, one.kind);
}

}  // namespace

std::string OsimNames::make(const std::string& wanted, std::set<std::string>& taken) {
  const std::string name = allowed_by_osim(wanted);
  std::string out = name;
  for (int i = 2; !taken.insert(out).second; ++i) out = fmt::format("{}_{}", name, i);
  return out;
}

OsimNames::OsimNames(const Scene& scene) {
  const Eigen::Vector3d& g = scene.gravity;
  if (g.x() == 0 && g.y() == 0 && g.z() < 0) X_GW_.R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  for (const Solid& solid : scene.solids) bodies_[solid.name] = new_body(solid.name);
  for (const Solid& solid : scene.solids)
    for (std::size_t i = 0; i < solid.switches.size(); ++i)
      if (is_scalar_switch(solid.switches[i])) {
        const std::string name = coordinate_name(solid, i);
        coordinates_[name] = new_coordinate(name);
      }
}

void OsimNames::report_renamed(Omissions& lost) const {
  std::set<std::pair<std::string, std::string>> pairs;  // a solid may bear its coordinate's name
  for (const auto* names : {&bodies_, &coordinates_}) pairs.insert(names->begin(), names->end());
  for (const auto& [from, to] : pairs)
    if (to != allowed_by_osim(from))
      lost.add("names that OpenSim would have twice get a number", fmt::format("'{}' as '{}'", from, to));
    else if (to != from)
      lost.add("names have _ for blanks and other characters that OpenSim does not allow", from);
}

}  // namespace borelli
