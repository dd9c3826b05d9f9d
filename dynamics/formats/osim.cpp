#include "dynamics/formats/osim.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "dynamics/formats/osim_constraint.hpp"
#include "dynamics/formats/osim_joint.hpp"
#include "dynamics/formats/placeholder_inertia.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// ---- what changes the motion ----

// Kinds of components that place, measure or show something.
bool only_marks(const XmlElement& e) {
  constexpr std::array kinds{"Frame", "Marker", "Station", "Geometry", "Mesh", "Probe", "Reporter", "Source"};
  return std::ranges::any_of(kinds, [&](const char* kind) { return e.name.ends_with(kind); });
}

// Only the sets whose content acts on the bodies are marked as read, so an object acts if its parent was
// read. Components may be of any kind.
bool osim_element_moves(const XmlElement& e, const XmlElement& parent) {
  if (parent.name == "defaults")  // (a CMC_Joint is a controller's task)
    return e.name == "Body" || e.name == "Coordinate" ||
           (e.name.ends_with("Joint") && !e.name.starts_with("CMC_"));
  return (parent.name == "objects" || parent.name == "components") && parent.read && !only_marks(e) &&
         osim_acts(e);
}

bool osim_attribute_moves(const XmlAttribute&, const XmlElement&) { return false; }

constexpr MotionRules osim_motion_rules{osim_element_moves, osim_attribute_moves};

// Names are no content of their own.
void mark_names(const XmlElement& element) {
  element.find("name");
  for (const XmlElement& c : element.children) mark_names(c);
}

// ---- bodies ----

Eigen::Matrix3d osim_inertia(const XmlElement& body) {
  std::vector<double> entries(6, 0);
  if (const XmlElement* six = body.child("inertia")) {
    entries = six->content_numbers(6, 6);
  } else {
    static constexpr const char* names[] = {"inertia_xx", "inertia_yy", "inertia_zz",
                                            "inertia_xy", "inertia_xz", "inertia_yz"};
    for (int i = 0; i < 6; ++i)
      if (const XmlElement* one = body.child(names[i])) entries[i] = one->content_numbers(1, 1)[0];
  }
  Eigen::Matrix3d out;
  out << entries[0], entries[3], entries[4], entries[3], entries[1], entries[5], entries[4], entries[5],
      entries[2];
  return out;
}

// The inertia is about the mass centre, in the body's axes.
void add_inertial_of(const XmlElement& body, Solid& solid) {
  Inertial own;
  if (const XmlElement* mass = body.child("mass")) own.mass = mass->content_numbers(1, 1)[0];
  own.centre = osim_vector(body, "mass_center");
  own.tensor = osim_inertia(body);
  if (own.mass < 0) body.refuse(fmt::format("has a mass of {:g} kg, expected 0 or more", own.mass));
  if (own.mass == 0 && own.tensor.isZero(0)) return;
  solid.inertials.push_back(own);
}

class OsimReader {
 public:
  explicit OsimReader(const XmlElement& root)
      : root_(root), model_(root.require_child("Model")), frames_(model_) {}

  ModelFile read(double minimum_mass) {
    out_.scene.name = model_.text("name");
    out_.scene.file = root_.file;
    out_.scene.gravity = osim_vector(model_, "gravity", {0, -9.80665, 0});
    check_root();
    const OsimLayout layout = read_osim_layout(model_, frames_);
    for (const XmlElement* body : layout.bodies) add_body(*body);
    if (out_.scene.solids.empty()) model_.refuse("contains no <Body>, so nothing can move");
    for (const OsimJoint& joint : layout.joints) add_joint(joint);
    for (Solid& solid : out_.scene.solids)
      if (!carried_.contains(solid.name)) set_free(solid);
    refuse_loops();
    read_osim_constraints(model_, frames_, out_.scene);
    read_markers();
    settle(minimum_mass);
    lock_massless_followers();
    osim_objects(model_, "ControllerSet");
    mark_names(root_);
    list_unread(root_, osim_motion_rules, out_.not_modelled);
    return std::move(out_);
  }

 private:
  void check_root() const {
    const std::string version = root_.text("Version");
    if (const std::string file = model_.text("file"); !file.empty())
      model_.refuse("file", fmt::format("is in another file, '{}'; give that file", printable(file)));
    if (!version.empty() && std::atoi(version.c_str()) < 10901)
      root_.refuse("Version", fmt::format("the file is of version {}, before OpenSim 2; open it in OpenSim 3 "
                                          "or 4 and save it",
                                          printable(version)));
    for (const char* text : {"credits", "publications"}) model_.child(text);
    for (const auto& [child, unit] : {std::pair{"length_units", "meters"}, {"force_units", "N"}})
      for (const XmlElement& c : model_.children)
        if (c.name == child && c.content == unit) c.read = true;
    for (const XmlElement& c : model_.children)
      if (c.name == "Ground") c.read = true;
  }

  void add_body(const XmlElement& body) {
    Solid solid;
    solid.name = body.text("name");
    solid.line = body.line;
    add_inertial_of(body, solid);
    number_[solid.name] = out_.scene.solids.size();
    out_.scene.solids.push_back(std::move(solid));
  }

  // Joints lead from the ground outwards. A joint whose child is the ground is taken the other way.
  void add_joint(const OsimJoint& joint) {
    OsimFrame parent = joint.parent, child = joint.child;
    std::vector<Switch> motion = joints_.read(joint);
    if (joint.inverted) motion = inverse_motion(std::move(motion));
    if (child.solid == world_name) {
      motion = inverse_motion(std::move(motion));
      std::swap(parent, child);
    }
    for (const OsimFrame* end : {&parent, &child})
      if (end->solid != world_name && !number_.contains(end->solid))
        joint.element->refuse(fmt::format("no body is named '{}'", printable(end->solid)));
    if (child.solid == world_name) joint.element->refuse("joins the ground to itself");
    const auto [before, is_new] = carried_.emplace(child.solid, joint.element);
    if (!is_new)
      joint.element->refuse(
          fmt::format("body '{}' is also the child of joint '{}'; loops of joints are not supported: close "
                      "the loop by a constraint",
                      printable(child.solid), printable(before->second->text("name"))));
    Solid& solid = out_.scene.solids[number_.at(child.solid)];
    solid.parent = parent.solid;
    add_placement(parent.X, solid);
    for (Switch& one : motion) solid.switches.push_back(std::move(one));
    add_placement(child.X.inverse(), solid);
  }

  static void add_placement(const Pose& X, Solid& solid) {
    if (X.R.isIdentity(0) && X.p.isZero(0)) return;
    solid.switches.emplace_back().kind = Fixed{X};
  }

  // OpenSim gives such a body a free joint to the ground.
  void set_free(Solid& solid) {
    const XmlElement free{.name = "FreeJoint", .file = root_.file, .line = solid.line};
    solid.switches = joints_.read({.name = "free_" + solid.name,
                                   .element = &free,
                                   .parent = {world_name, {}},
                                   .child = {solid.name, {}},
                                   .coordinates = {}});
    out_.not_modelled.other.push_back(fmt::format("body '{}' has no joint and moves freely: at {}:{}",
                                                  printable(solid.name), root_.file, solid.line));
  }

  void refuse_loops() const {
    std::map<std::string, const std::string*> seen;  // per solid: the start of the last walk through it
    for (const Solid& start : out_.scene.solids)
      for (std::string name = start.name; name != world_name;) {
        const auto [at, is_new] = seen.emplace(name, &start.name);
        if (!is_new && at->second == &start.name)
          carried_.at(name)->refuse(fmt::format("body '{}' is its own ancestor", printable(name)));
        if (!is_new) break;
        name = out_.scene.solids[number_.at(name)].parent;
      }
  }

  void read_markers() {
    std::set<std::string> names;
    std::vector<const XmlElement*> objects = osim_objects(model_, "MarkerSet");
    for (const XmlElement* e : osim_components(model_)) objects.push_back(e);
    for (const XmlElement* e : objects) {
      if (e->name != "Marker") continue;
      e->read = true;
      Marker marker{e->require("name"), {}, e->line};
      if (marker.name.empty()) e->refuse("has an empty name; give it a name");
      if (!names.insert(marker.name).second) e->refuse("has the name of another one; rename one of them");
      const OsimFrame frame = frames_.named_by(*e, {"socket_parent_frame", "socket_reference_frame", "body"});
      if (frame.solid != world_name && !number_.contains(frame.solid))
        e->refuse(fmt::format("no body is named '{}'", printable(frame.solid)));
      marker.at = {frame.solid, frame.X * osim_vector(*e, "location")};
      e->child("fixed");
      out_.scene.markers.push_back(std::move(marker));
    }
  }

  void settle(double minimum_mass) {
    auto settled = settle_inertias(out_.scene, minimum_mass);
    if (!settled) {
      const auto solid = number_.find(settled.error().where);
      const int line = solid == number_.end() ? 0 : out_.scene.solids[solid->second].line;
      throw XmlRefusal{
          Error{fmt::format("{}:{}", root_.file, line),
                fmt::format("of body '{}': {}", printable(settled.error().where), settled.error().what),
                Error::Kind::use}};
    }
    for (std::string& line : settled->motion) out_.not_modelled.motion.push_back(std::move(line));
    for (std::string& line : settled->other) out_.not_modelled.other.push_back(std::move(line));
  }

  // A coordinate that follows another and moves no mass stays where it starts, since no force could hold it.
  void lock_massless_followers() {
    std::set<std::string> weighs;  // solids that have, or carry, mass
    for (const Solid& solid : out_.scene.solids)
      if (!solid.inertials.empty())
        for (std::string at = solid.name; at != world_name && weighs.insert(at).second;)
          at = out_.scene.solids[number_.at(at)].parent;
    std::map<std::string, const Switch*> known;
    for (const Solid& solid : out_.scene.solids)
      for (const Switch& one : solid.switches) known[one.coordinate] = &one;
    std::vector<std::string> names;
    for (Solid& solid : out_.scene.solids)
      for (Switch& one : solid.switches) {
        const auto* coupled = std::get_if<Coupled>(&one.motion);
        if (!coupled || weighs.contains(solid.name)) continue;
        one.q = {at(coupled->function, start_of(*known.at(coupled->to))).value};
        one.motion = Locked{};
        names.push_back(one.coordinate);
      }
    if (!names.empty())
      out_.not_modelled.motion.push_back("locked coordinates, which follow others and move no mass: " +
                                         name_list(names));
  }

  // Where a coordinate starts that is free, locked or driven; 0 for one that follows another itself.
  static double start_of(const Switch& one) {
    if (const auto* driven = std::get_if<Driven>(&one.motion)) return at(driven->functions[0], 0).value;
    return one.q.empty() ? 0 : one.q[0];
  }

  const XmlElement& root_;
  const XmlElement& model_;
  OsimFrames frames_;
  ModelFile out_;
  OsimJoints joints_{out_.not_modelled};
  std::map<std::string, std::size_t> number_;         // of solids
  std::map<std::string, const XmlElement*> carried_;  // per solid: its joint
};

}  // namespace

ModelFile read_osim(const XmlElement& root, double minimum_mass) {
  return OsimReader(root).read(minimum_mass);
}

}  // namespace borelli
