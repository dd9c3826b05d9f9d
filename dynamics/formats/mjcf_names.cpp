#include "dynamics/formats/mjcf_names.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <sstream>

namespace borelli {
namespace {

struct Names {
  std::string attributes;  // "*": any
  std::string children;
};

constexpr const char* orientations = " quat axisangle xyaxes zaxis euler";

// By element name, or "parent/element" if a name has two meanings.
const std::map<std::string, Names, std::less<>>& known_names() {
  static const std::string body_parts =
      "inertial joint freejoint geom site camera light body plugin composite flexcomp frame attach replicate";
  static const std::map<std::string, Names, std::less<>> names{
      {"mujoco",
       {"model",
        "compiler option size visual statistic default asset worldbody contact deformable equality tendon "
        "actuator "
        "sensor keyframe custom extension"}},
      {"compiler",
       {"autolimits boundmass boundinertia settotalmass balanceinertia strippath coordinate angle fitaabb "
        "eulerseq "
        "meshdir texturedir assetdir discardvisual usethread fusestatic inertiafromgeom inertiagrouprange "
        "exactmeshinertia convexhull saveinertial alignfree conflict",
        "lengthrange"}},
      {"option",
       {"timestep apirate impratio tolerance ls_tolerance noslip_tolerance mpr_tolerance ccd_tolerance "
        "sleep_tolerance "
        "gravity wind magnetic density viscosity o_margin o_solref o_solimp o_friction integrator collision "
        "cone "
        "jacobian solver iterations ls_iterations noslip_iterations mpr_iterations ccd_iterations "
        "sdf_iterations "
        "sdf_initpoints actuatorgroupdisable",
        "flag"}},
      {"flag", {"*", ""}},
      {"default",
       {"class",
        "default joint geom mesh equality site camera light material pair tendon general motor position "
        "velocity "
        "intvelocity damper cylinder muscle adhesion"}},
      {"default/equality", {"active solref solimp", ""}},
      {"asset", {"", "mesh texture material hfield skin model"}},
      {"mesh",
       {"name class content_type file vertex normal texcoord face refpos refquat scale smoothnormal "
        "maxhullvert inertia "
        "builtin params material octree",
        "plugin"}},
      {"worldbody", {"name", body_parts}},
      {"body",
       {"name childclass pos mocap gravcomp sleep simple user" + std::string(orientations), body_parts}},
      {"frame", {"name childclass pos" + std::string(orientations), body_parts}},
      {"replicate", {"count offset euler sep childclass", body_parts}},
      {"attach", {"model body frame prefix", ""}},
      {"model", {"name file content_type", ""}},
      {"composite",
       {"prefix type count spacing offset vertex initial curve size quat", "joint geom site skin plugin"}},
      {"composite/joint",
       {"kind group stiffness damping armature solreffix solimpfix type axis limited range margin "
        "solreflimit solimplimit frictionloss solreffriction solimpfriction",
        ""}},
      {"composite/geom",
       {"type contype conaffinity condim group priority size material rgba friction mass density solmix "
        "solref "
        "solimp margin gap surfacevel adhesion",
        ""}},
      {"inertial", {"pos mass diaginertia fullinertia" + std::string(orientations), ""}},
      {"joint",
       {"name class type group pos axis springdamper solreflimit solimplimit solreffriction solimpfriction "
        "stiffness "
        "range limited actuatorfrclimited actuatorfrcrange actuatorgravcomp margin ref springref armature "
        "damping "
        "frictionloss user",
        ""}},
      {"freejoint", {"name group align", ""}},
      {"geom",
       {"name class type pos contype conaffinity condim group priority size material friction mass density "
        "shellinertia "
        "solmix solref solimp margin gap surfacevel adhesion fromto hfield mesh fitscale rgba fluidshape "
        "fluidcoef user" +
            std::string(orientations),
        "plugin"}},
      {"equality", {"", "connect weld joint tendon flex flexvert flexstrain distance"}},
      {"connect", {"name class active body1 body2 site1 site2 anchor solref solimp", ""}},
      {"weld", {"name class active body1 body2 site1 site2 anchor relpose torquescale solref solimp", ""}},
      {"equality/joint", {"name class active joint1 joint2 polycoef solref solimp", ""}}};
  return names;
}

bool holds(const std::string& words, const std::string& word) {
  std::istringstream list(words);
  for (std::string one; list >> one;)
    if (one == word) return true;
  return false;
}

void check(const XmlElement& element, const Names& known) {
  for (const XmlAttribute& a : element.attributes)
    if (known.attributes != "*" && !holds(known.attributes, a.name))
      element.refuse(a.name, fmt::format("unknown attribute '{}'; known: {}", a.name, known.attributes));
  for (const XmlElement& c : element.children) {
    if (!holds(known.children, c.name))
      c.refuse(fmt::format("unknown element in <{}>; known: {}", element.name, known.children));
    if (c.name == "flexcomp")
      c.refuse("soft bodies (flex) are not supported; remove this element to read the rest");
    const auto& names = known_names();
    auto own = names.find(element.name + "/" + c.name);
    if (own == names.end()) own = names.find(c.name);
    // elements without an entry of their own are not checked further
    if (own != names.end()) check(c, own->second);
  }
}

}  // namespace

void check_mjcf_names(const XmlElement& root) { check(root, known_names().at("mujoco")); }

}  // namespace borelli
