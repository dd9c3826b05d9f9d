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

// The value of an option that replaces those of all contacts.
bool overrides(const XmlElement& option) {
  for (const XmlElement& flag : option.children)
    if (flag.name == "flag" && flag.text("override") == "enable") return true;
  return false;
}

bool attribute_moves(const XmlAttribute& a, const XmlElement& e) {
  static const std::map<std::string, Words, std::less<>> moving{
      {"option", {"density", "viscosity", "wind", "o_margin", "o_solref", "o_solimp"}},
      {"joint", {"springdamper", "frictionloss", "margin", "solreflimit", "solimplimit", "solref", "solimp"}},
      {"connect", {"solref", "solimp"}},
      {"weld", {"solref", "solimp"}},
      {"geom", {"solref", "solimp", "margin", "gap", "surfacevel", "adhesion"}},
      {"pair", {"solref", "solimp", "margin", "gap", "solreffriction", "adhesion"}}};
  const auto names = moving.find(e.name);
  if (names == moving.end() || !names->second.contains(a.name) || all_zero(a.value)) return false;
  if (a.name.starts_with("o_")) return overrides(e);
  return e.name != "geom" || touches(e);
}

}  // namespace

void mark_switched_off(const XmlElement& e, const MjcfSwitches& switches) {
  const auto off = [&](const char* name, bool on) {
    if (e.name == name && !on) mark_read(e);
  };
  off("equality", switches.equality);
  off("contact", switches.contact);
  off("actuator", switches.actuation);
  const auto without = [&](bool on, std::initializer_list<const char*> attributes) {
    if (!on)
      for (const char* name : attributes) e.find(name);
  };
  if (e.name == "joint") {
    without(switches.friction_loss, {"frictionloss", "solreffriction", "solimpfriction"});
    without(switches.limits, {"margin", "solreflimit", "solimplimit"});
  }
  if (e.name == "geom") without(switches.contact, {"solref", "solimp", "margin", "gap", "adhesion"});
  for (const XmlElement& c : e.children) mark_switched_off(c, switches);
}

MotionRules mjcf_motion_rules() { return {element_moves, attribute_moves}; }

}  // namespace borelli
