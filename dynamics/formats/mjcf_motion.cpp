#include "dynamics/formats/mjcf_motion.hpp"

#include <map>
#include <set>

namespace borelli {
namespace {

using Words = std::set<std::string, std::less<>>;

bool all_zero(const std::string& numbers) { return numbers.find_first_of("123456789") == std::string::npos; }

// Contact attributes of a geom that touches nothing have no effect.
bool touches(const XmlElement& geom) {
  return !all_zero(geom.text("contype", "1")) || !all_zero(geom.text("conaffinity", "1"));
}

bool element_moves(const XmlElement& e, const XmlElement& parent) {
  if (parent.name == "actuator" || parent.name == "tendon") return true;
  if (parent.name == "equality") return e.text("active", "true") == "true";
  if (parent.name == "deformable") return e.name == "flex";
  return e.name == "plugin" && (parent.name == "body" || parent.name == "worldbody" || parent.name == "geom");
}

bool attribute_moves(const XmlAttribute& a, const XmlElement& e) {
  static const std::map<std::string, Words, std::less<>> moving{
      {"option", {"density", "viscosity", "wind"}},
      {"joint", {"springdamper", "frictionloss", "margin", "solreflimit", "solimplimit", "solref", "solimp"}},
      {"connect", {"solref", "solimp"}},
      {"weld", {"solref", "solimp"}},
      {"geom", {"solref", "solimp", "margin", "gap", "surfacevel", "adhesion"}},
      {"pair", {"solref", "solimp", "margin", "gap", "solreffriction", "adhesion"}}};
  const auto names = moving.find(e.name);
  if (names == moving.end() || !names->second.contains(a.name) || all_zero(a.value)) return false;
  return e.name != "geom" || touches(e);
}

}  // namespace

MotionRules mjcf_motion_rules() { return {element_moves, attribute_moves}; }

}  // namespace borelli
