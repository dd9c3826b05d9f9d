#include "dynamics/formats/mjcf.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "dynamics/formats/mjcf_assemble.hpp"
#include "dynamics/formats/mjcf_contact.hpp"
#include "dynamics/formats/mjcf_equality.hpp"
#include "dynamics/formats/mjcf_geom.hpp"
#include "dynamics/formats/mjcf_inertia.hpp"
#include "dynamics/formats/mjcf_joint.hpp"
#include "dynamics/formats/mjcf_motion.hpp"
#include "dynamics/formats/mjcf_site.hpp"
#include "dynamics/formats/unread.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// The modelled settings of <option>.
struct Options {
  Vector3d gravity{0, 0, -9.81};
  double timestep = 0;
  MjcfJoints::Acting joints;
  MjcfSwitches on;

  explicit Options(const XmlElement& root) {
    bool weight = true, passive = true;
    for (const XmlElement& e : root.children) {
      if (e.name != "option") continue;
      e.read = true;
      gravity = e.vector("gravity", gravity);
      timestep = e.number("timestep", timestep);
      if (e.has("timestep") && !(timestep > 0))
        e.refuse("timestep",
                 fmt::format("timestep is {:g}, expected a positive number of seconds", timestep));
      const XmlElement* flag = e.child("flag");
      if (!flag) continue;
      const auto enabled = [&](const char* key, bool standard) {
        return flag->word(key, {"enable", "disable"}, standard ? "enable" : "disable") == "enable";
      };
      weight = enabled("gravity", weight);
      passive = enabled("passive", passive);
      joints.springs = passive && enabled("spring", joints.springs);
      joints.dampers = passive && enabled("damper", joints.dampers);
      const bool constraints = enabled("constraint", true);
      joints.limits = constraints && enabled("limit", joints.limits);
      on.limits = joints.limits;
      on.equality = constraints && enabled("equality", on.equality);
      on.contact = constraints && enabled("contact", on.contact);
      on.friction_loss = constraints && enabled("frictionloss", on.friction_loss);
      on.actuation = enabled("actuation", on.actuation);
    }
    if (!weight) gravity.setZero();
  }
};

class MjcfReader {
 public:
  explicit MjcfReader(const MjcfModel& model)
      : root_(model.root),
        compilers_(model.compilers),
        options_(root_),
        geoms_(root_, compilers_),
        contacts_(root_),
        sites_(root_),
        joints_(compilers_, options_.joints, model_.not_modelled.motion) {}

  ModelFile read() {
    model_.scene.name = root_.text("model");
    model_.scene.gravity = options_.gravity;
    if (options_.timestep > 0) model_.scene.simulation.step = options_.timestep;
    for (const XmlElement& section : root_.children)
      if (section.name == "worldbody") take_names(section), joints_.take_names(section);
    for (const XmlElement& section : root_.children)
      if (section.name == "worldbody") add_world(section);
    scale_to_total_mass();
    if (options_.joints.springs || options_.joints.dampers) compensate_gravity();
    sites_.add_springs(root_, poses_, options_.joints, model_.scene.efforts);
    read_mjcf_start(root_, model_.scene);
    if (options_.on.equality) model_.scene.constraints = read_mjcf_equality(root_, poses_, joints_.named());
    if (std::string line = joints_.aligned(); !line.empty())
      model_.not_modelled.motion.push_back(std::move(line));
    if (std::string line = geoms_.gaps(); !line.empty())
      model_.not_modelled.motion.push_back(std::move(line));
    if (std::string line = geoms_.overweight(); !line.empty())
      model_.not_modelled.other.push_back(std::move(line));
    if (meshes_not_seen_ > 0)
      model_.not_modelled.other.push_back(fmt::format(
          "the appearance of {} mesh geoms (they have mass, but are not drawn)", meshes_not_seen_));
    if (options_.on.contact) add_contacts();
    mark_switched_off(root_, options_.on);
    list_unread(root_, mjcf_motion_rules(), model_.not_modelled);
    return std::move(model_);
  }

 private:
  void take_names(const XmlElement& parent) {
    for (const XmlElement& c : parent.children) {
      if (c.name != "body") continue;
      const std::string name = c.text("name");
      if (name == world_name) c.refuse("has the fixed frame's name; rename it");
      if (!name.empty() && !joints_.solid_names.take(name))
        c.refuse("there are two bodies of this name; rename one");
      take_names(c);
    }
  }

  void add_world(const XmlElement& worldbody) {
    worldbody.read = true;
    worldbody.find("name");
    poses_[world_name] = Pose{};
    Solid floor;
    const MjcfContacts::Body world{world_name, world_name, world_name, ""};
    read_geoms(worldbody, floor, world);
    sites_.read(worldbody, world_name, model_.scene.markers);
    if (!floor.shapes.empty()) {
      floor.name = joints_.solid_names.make("worldbody");
      model_.scene.solids.push_back(std::move(floor));
    }
    for (const XmlElement& c : worldbody.children)
      if (c.name == "body") add_body(c, world, Pose{});
  }

  void add_body(const XmlElement& body, const MjcfContacts::Body& parent, const Pose& X_WP) {
    body.read = true;
    body.find("childclass");
    Solid solid;
    solid.name = body.text("name");
    if (solid.name.empty())
      solid.name = joints_.solid_names.make(fmt::format("body {}", ++bodies_without_name_));
    solid.parent = parent.solid;
    const Pose X_PS = compilers_.pose_of(body);
    const Pose X_WS = X_WP * X_PS;
    poses_[solid.name] = X_WS;

    const bool moves = std::any_of(body.children.begin(), body.children.end(), [](const XmlElement& c) {
      return c.name == "joint" || c.name == "freejoint";
    });
    const MjcfContacts::Body self{body.text("name"), solid.name, moves ? solid.name : parent.weld,
                                  moves ? parent.weld : parent.weld_parent};
    const Inertial own = mjcf_inertial(body, read_geoms(body, solid, self), compilers_);
    if (own.mass > 0 || !own.tensor.isZero(0)) solid.inertials.push_back(own);
    sites_.read(body, solid.name, model_.scene.markers);
    std::vector<Solid> before;
    joints_.read(body, X_PS, solid, before, model_.scene.efforts);
    for (Solid& s : before) model_.scene.solids.push_back(std::move(s));
    if (const double share = body.number("gravcomp", 0); share != 0)
      compensated_.emplace_back(model_.scene.solids.size(), share);
    model_.scene.solids.push_back(std::move(solid));
    for (const XmlElement& c : body.children)
      if (c.name == "body") add_body(c, self, X_WS);
  }

  // Reads the geoms of a body and adds their shapes to the solid.
  std::vector<MjcfGeom> read_geoms(const XmlElement& body, Solid& solid, const MjcfContacts::Body& self) {
    const bool weighs = weighs_by_geoms(body, compilers_);
    std::vector<MjcfGeom> out;
    for (const XmlElement& c : body.children) {
      if (c.name != "geom") continue;
      const MjcfGeom& geom = out.emplace_back(geoms_.read(c, weighs));
      contacts_.add(c, geom, self);
      if (geom.shape) solid.shapes.push_back(*geom.shape);
      meshes_not_seen_ += !geom.shape && !geom.plane && c.read;
    }
    return out;
  }

  double freedoms() const {
    double out = 0;
    for (const Solid& solid : model_.scene.solids)
      for (const Switch& one : solid.switches)
        out += std::visit([](const auto& kind) { return kind.nv; }, one.kind);
    return out;
  }

  // `moreau` suits many contacts that open and close. Its step is the model's, or MuJoCo's default. Overlaps
  // at the start are separated, where MuJoCo pushes them apart.
  void add_contacts() {
    UniqueNames names;
    for (const Constraint& c : model_.scene.constraints) names.take(c.name);
    MjcfContacts::Found found = contacts_.find(std::move(names), freedoms());
    if (!found.contacts.empty()) {
      model_.scene.simulation.method = "moreau";
      model_.scene.simulation.put_apart = true;
      if (!(options_.timestep > 0)) model_.scene.simulation.step = 2e-3;
    }
    for (Constraint& c : found.contacts) model_.scene.constraints.push_back(std::move(c));
    if (found.twisting > 0)
      model_.not_modelled.motion.push_back(fmt::format(
          "torsional and rolling friction (condim 4 and 6) of {} pairs of geoms", found.twisting));
    if (found.directed > 0)
      model_.not_modelled.motion.push_back(
          fmt::format("friction that differs by direction of {} pairs of geoms: the first of its two "
                      "coefficients acts in all",
                      found.directed));
    if (found.crowded > 0)
      model_.not_modelled.motion.push_back(fmt::format(
          "contacts of {} pairs of geoms, too many to solve together with {:.0f} coordinates: they "
          "pass through each other",
          found.crowded, freedoms()));
    if (found.without.pairs.size() > found.crowded)
      model_.not_modelled.motion.push_back(fmt::format(
          "contacts of {} pairs of geoms that may touch, such as {} and {}: they pass through each other; "
          "contacts of height fields, and of meshes whose files cannot be read, are not modelled",
          found.without.pairs.size() - found.crowded, found.first.first, found.first.second));
    model_.without_contact = std::move(found.without);
  }

  void scale_to_total_mass() {
    const double total = compilers_.all[0].total_mass;
    if (!(total > 0)) return;
    double whole = 0;
    for (const Solid& solid : model_.scene.solids)
      for (const Inertial& i : solid.inertials) whole += i.mass;
    if (!(whole > 0)) return;
    for (Solid& solid : model_.scene.solids)
      for (Inertial& i : solid.inertials) {
        i.mass *= total / whole;
        i.tensor *= total / whole;
      }
  }

  // gravcomp: a force at the centre of mass carries this share of the weight.
  void compensate_gravity() {
    for (const auto& [index, share] : compensated_) {
      const Solid& solid = model_.scene.solids[index];
      if (solid.inertials.empty()) continue;
      const Inertial& own = solid.inertials[0];
      model_.scene.efforts.push_back(
          {"gravcomp of " + solid.name, Force{.at = {solid.name, own.centre},
                                              .force = -share * own.mass * options_.gravity,
                                              .axes = Axes::world,
                                              .factor = constant(1),
                                              .reaction = {}}});
    }
  }

  const XmlElement& root_;
  ModelFile model_;
  const MjcfCompilers& compilers_;
  const Options options_;
  MjcfGeoms geoms_;
  MjcfContacts contacts_;
  MjcfSites sites_;
  MjcfJoints joints_;
  std::map<std::string, Pose> poses_;  // X_WS in the initial pose of the model
  std::vector<std::pair<std::size_t, double>> compensated_;
  int bodies_without_name_ = 0, meshes_not_seen_ = 0;
};

}  // namespace

ModelFile read_mjcf(XmlElement root) {
  const MjcfModel model = assemble_mjcf(std::move(root));
  return MjcfReader(model).read();
}

}  // namespace borelli
