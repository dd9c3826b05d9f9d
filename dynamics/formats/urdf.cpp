#include "dynamics/formats/urdf.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>

#include "dynamics/formats/placeholder_inertia.hpp"
#include "dynamics/formats/unread.hpp"
#include "dynamics/numbers/rotation_between.hpp"
#include "dynamics/scene/free_joint.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void refuse_xacro(const XmlElement& element) {
  for (const XmlElement& c : element.children) {
    if (c.name.starts_with("xacro:"))
      c.refuse(
          "is xacro, a language that generates URDF; expand the file (xacro FILE > robot.urdf) and read the "
          "result");
    refuse_xacro(c);
  }
}

// ---- what changes the motion ----

bool is_physics_of_gazebo(const XmlElement& e) {
  static const std::set<std::string, std::less<>> names{"mu1",
                                                        "mu2",
                                                        "fdir1",
                                                        "kp",
                                                        "kd",
                                                        "maxVel",
                                                        "minDepth",
                                                        "maxContacts",
                                                        "gravity",
                                                        "turnGravityOff",
                                                        "selfCollide",
                                                        "self_collide",
                                                        "dampingFactor",
                                                        "implicitSpringDamper",
                                                        "springStiffness",
                                                        "springReference",
                                                        "stopCfm",
                                                        "stopErp",
                                                        "cfmDamping",
                                                        "fudgeFactor",
                                                        "plugin"};
  return names.contains(e.name);
}

bool urdf_element_moves(const XmlElement& e, const XmlElement& parent) {
  return e.name == "transmission" || e.name == "safety_controller" ||
         (e.name == "contact" && parent.name == "link") ||
         (parent.name == "gazebo" && is_physics_of_gazebo(e));
}

bool urdf_attribute_moves(const XmlAttribute& a, const XmlElement& e) {
  return e.name == "dynamics" && a.name == "friction" &&
         a.value.find_first_of("123456789") != std::string::npos;
}

constexpr MotionRules urdf_motion_rules{urdf_element_moves, urdf_attribute_moves};

// ---- placements, inertia, shapes ----

// The rotation by roll about x, then pitch about y, then yaw about z, all fixed axes.
Matrix3d from_roll_pitch_yaw(const Vector3d& rpy) {
  return rotation_about(Vector3d::UnitZ(), rpy[2]) * rotation_about(Vector3d::UnitY(), rpy[1]) *
         rotation_about(Vector3d::UnitX(), rpy[0]);
}

// The pose that the <origin> of an element gives.
Pose origin_of(const XmlElement& element) {
  const XmlElement* origin = element.child("origin");
  if (!origin) return {};
  return {from_roll_pitch_yaw(origin->vector("rpy", Vector3d::Zero())),
          origin->vector("xyz", Vector3d::Zero())};
}

void add_inertial(const XmlElement& link, Solid& solid) {
  const XmlElement* element = link.child("inertial");
  if (!element) return;
  const Pose X = origin_of(*element);
  const XmlElement &mass = element->require_child("mass"), &inertia = element->require_child("inertia");
  mass.require("value");
  Inertial own;
  own.mass = mass.number("value", 0);
  for (const char* key : {"ixx", "iyy", "izz"}) inertia.require(key);
  const double xx = inertia.number("ixx", 0), yy = inertia.number("iyy", 0), zz = inertia.number("izz", 0);
  const double xy = inertia.number("ixy", 0), xz = inertia.number("ixz", 0), yz = inertia.number("iyz", 0);
  own.tensor << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  if (own.mass == 0 && own.tensor.isZero(0)) return;
  if (own.mass < 0)
    element->refuse(
        fmt::format("of link '{}' has a mass of {:g} kg, expected 0 or more", solid.name, own.mass));
  solid.inertials.push_back(own.expressed_in(X.R, X.p));
}

// The form of a <geometry>. None: a mesh, or a primitive without size, whose place goes to `without_size`.
std::optional<Form> form_of(const XmlElement& geometry, std::vector<std::string>& without_size) {
  std::optional<Form> form;
  double least = 0;
  const auto size = [](const XmlElement& e, const char* key) {
    e.require(key);
    return e.number(key, 0);
  };
  const XmlElement* e = nullptr;
  if ((e = geometry.child("box"))) {
    e->require("size");
    const Vector3d edges = e->vector("size", Vector3d::Zero());
    least = edges.minCoeff();
    form = Box{edges};
  } else if ((e = geometry.child("sphere"))) {
    least = size(*e, "radius");
    form = Sphere{least};
  } else if ((e = geometry.child("cylinder"))) {
    const double radius = size(*e, "radius"), length = size(*e, "length");
    least = std::min(radius, length);
    form = Cylinder{radius, length};
  } else if ((e = geometry.child("capsule"))) {
    const double radius = size(*e, "radius"), length = size(*e, "length");
    least = std::min(radius, length);
    form = Capsule{radius, length};
  }
  if (form && !(least > 0)) without_size.push_back(e->where()), form.reset();
  return form;
}

void add_shapes(const XmlElement& link, Solid& solid, std::vector<std::string>& without_size) {
  const auto count = std::count_if(link.children.begin(), link.children.end(),
                                   [](const XmlElement& c) { return c.name == "visual"; });
  const std::string_view kind = count > 0 ? "visual" : "collision";
  for (const XmlElement& c : link.children) {
    if (c.name != kind) continue;
    c.read = true;
    c.find("name");
    const Pose X = origin_of(c);
    if (const auto form = form_of(c.require_child("geometry"), without_size)) {
      const Quaternion q = quaternion(X.R);
      solid.shapes.push_back({.shape = {*form, X.p, {q[0], q[1], q[2], q[3]}}, .density = {}, .mass = {}});
    }
  }
}

// ---- joints ----

Switch moving(SwitchKind kind, std::string name) {
  Switch out;
  out.kind = std::move(kind);
  out.coordinate = std::move(name);
  return out;
}

class UrdfReader {
 public:
  explicit UrdfReader(const XmlElement& root) : root_(root) {}

  ModelFile read(const ModelOptions& options) {
    refuse_xacro(root_);
    model_.scene.name = root_.text("name");
    collect();
    const std::string root_link = find_root();
    add_root(root_link, options.floating);
    for (const XmlElement* joint : joints_) add_joint(*joint);
    for (const XmlElement* joint : joints_) add_mimic(*joint);
    start_followers();
    if (auto done = lock_coordinates(model_.scene, options.locked); !done)
      throw XmlRefusal{Error{root_.file, done.error().message(), Error::Kind::use}};
    settle(options.minimum_mass);
    say_no_contacts();
    if (!without_size_.empty())
      model_.not_modelled.other.push_back(fmt::format("shapes without a size: {} times, first at {}",
                                                      without_size_.size(), without_size_.front()));
    list_unread(root_, urdf_motion_rules, model_.not_modelled);
    return std::move(model_);
  }

 private:
  void collect() {
    for (const XmlElement& c : root_.children) {
      if (c.name == "mujoco")  // MuJoCo's extension: whether it joins welded links changes no motion
        if (const XmlElement* compiler = c.child("compiler");
            compiler && !compiler->text("fusestatic").empty())
          c.read = true;
      if (c.name != "link" && c.name != "joint") continue;
      c.read = true;
      const std::string& name = c.require("name");
      if (name.empty()) c.refuse("has an empty name; give it a name");
      auto& known = c.name == "link" ? links_ : joint_names_;
      if (!known.emplace(name, &c).second) c.refuse("has the name of another one; rename one of them");
      if (c.name == "joint") joints_.push_back(&c);
    }
    if (links_.empty()) root_.refuse("has no <link>");
    // A joint may name the world as its parent although the file has no link of that name.
    for (const XmlElement* joint : joints_)
      if (const XmlElement* parent = joint->child("parent");
          parent && parent->text("link") == world_name && links_.emplace(world_name, &world_).second) {
        world_.file = parent->file;
        world_.line = parent->line;
      }
  }

  void say_no_contacts() {
    int count = 0;
    const XmlElement* first = nullptr;
    for (const auto& [name, link] : links_)
      for (const XmlElement& c : link->children)
        if (c.name == "collision") {
          ++count;
          if (!first || c.line < first->line) first = &c;
          mark_read(c);
        }
    if (first)
      model_.not_modelled.motion.push_back(fmt::format(
          "contacts of {} <collision>, links pass through each other: first at {}", count, first->where()));
  }

  const std::string& link_of(const XmlElement& joint, const char* which) const {
    const XmlElement& end = joint.require_child(which);
    const std::string& link = end.require("link");
    if (!links_.contains(link)) end.refuse("link", fmt::format("there is no link named '{}'", link));
    return link;
  }

  void settle(double minimum_mass) {
    auto settled = settle_inertias(model_.scene, minimum_mass);
    if (!settled) {
      const auto link = links_.find(settled.error().where);
      const XmlElement* inertial = link == links_.end() ? nullptr : link->second->child("inertial");
      (inertial ? *inertial : root_)
          .refuse(fmt::format("of link '{}': {}", settled.error().where, settled.error().what));
    }
    for (std::string& line : settled->motion) model_.not_modelled.motion.push_back(std::move(line));
    for (std::string& line : settled->other) model_.not_modelled.other.push_back(std::move(line));
  }

  // The root: the only link that is no joint's child. All others must be reachable from it.
  std::string find_root() {
    std::map<std::string, const XmlElement*> above;  // per link: the joint that carries it
    for (const XmlElement* joint : joints_) {
      link_of(*joint, "parent");
      const std::string& child = link_of(*joint, "child");
      if (!above.emplace(child, joint).second)
        joint->refuse(fmt::format("link '{}' is also the child of joint '{}'; URDF allows no loops", child,
                                  above.at(child)->text("name")));
    }
    std::vector<std::string> roots;
    for (const auto& [name, link] : links_)
      if (!above.contains(name)) roots.push_back(name);
    if (roots.size() > 1)
      links_.at(roots[1])->refuse(
          fmt::format("has no parent joint, so there are several roots: {}; expected one", name_list(roots)));
    std::map<std::string, std::size_t> passed;  // the walk, by number, that visited a link first
    for (const auto& [name, joint] : above) {
      const std::size_t start = passed.size() + 1;
      std::string at = name;
      for (auto up = above.find(at); up != above.end(); up = above.find(at)) {
        const auto [by, is_new] = passed.emplace(at, start);
        if (!is_new && by->second == start) joint->refuse(fmt::format("link '{}' is its own ancestor", name));
        if (!is_new) break;
        at = link_of(*up->second, "parent");
      }
    }
    return roots.at(0);
  }

  Solid solid_of(const std::string& link) {
    Solid solid;
    solid.name = link;
    const XmlElement& element = *links_.at(link);
    add_inertial(element, solid);
    add_shapes(element, solid, without_size_);
    return solid;
  }

  void add_root(const std::string& link, bool floating) {
    Solid solid = solid_of(link);
    if (link == world_name) {
      if (floating)
        links_.at(link)->refuse(
            "is the root and has the world's name, so it cannot float; leave out --floating");
      if (solid.inertials.empty() && solid.shapes.empty()) return;
      solid.name = "world link";
      while (links_.contains(solid.name)) solid.name += "'";
    }
    if (floating) solid.switches = free_joint(link, Pose{});
    if (floating)
      for (const Switch& s : solid.switches) coordinates_.insert(s.coordinate);
    model_.scene.solids.push_back(std::move(solid));
  }

  void add_joint(const XmlElement& joint) {
    const std::string& link = link_of(joint, "child");
    if (link == world_name)
      links_.at(link)->refuse("has the fixed frame's name but is not the root; rename it");
    Solid solid = solid_of(link);
    solid.parent = link_of(joint, "parent");
    if (const Pose X = origin_of(joint); !X.R.isIdentity(0) || !X.p.isZero(0)) {
      Switch& placed = solid.switches.emplace_back();
      placed.kind = Fixed{X};
    }
    for (Switch& s : motion_of(joint)) {
      if (!coordinates_.insert(s.coordinate).second)
        joint.refuse(fmt::format("there are two coordinates named '{}'; rename one", s.coordinate));
      solid.switches.push_back(std::move(s));
    }
    model_.scene.solids.push_back(std::move(solid));
  }

  std::vector<Switch> motion_of(const XmlElement& joint) {
    const std::string& name = joint.require("name");
    joint.require("type");
    const std::string type = joint.word(
        "type", {"fixed", "revolute", "continuous", "prismatic", "floating", "planar", "spherical"}, "");
    if (type == "fixed") return {};
    if (type == "floating") return free_joint(name, Pose{});
    if (type == "spherical") return {moving(Ball{}, name)};
    const Vector3d axis = axis_of(joint);
    if (type == "planar") {
      const Matrix3d R = rotation_between(Vector3d::UnitZ(), axis);
      return {moving(Translation{R.col(0)}, name + ".x"), moving(Translation{R.col(1)}, name + ".y"),
              moving(Rotation{axis}, name + ".turn")};
    }
    SwitchKind kind = Rotation{axis};
    if (type == "prismatic") kind = Translation{axis};
    Switch one = moving(kind, name);
    if (type != "continuous") add_limits(joint, one);
    add_damping(joint, name);
    return {one};
  }

  static Vector3d axis_of(const XmlElement& joint) {
    const XmlElement* element = joint.child("axis");
    if (!element) return Vector3d::UnitX();
    element->require("xyz");
    const Vector3d axis = element->vector("xyz", Vector3d::UnitX());
    if (axis.norm() < 1e-12) element->refuse("xyz", "xyz has no direction");
    return axis.normalized();
  }

  void add_limits(const XmlElement& joint, Switch& one) {
    const XmlElement* limit = joint.child("limit");
    if (!limit || !(limit->has("lower") || limit->has("upper"))) return;
    const Range range{limit->number("lower", 0), limit->number("upper", 0)};
    if (range.lower > range.upper) {
      model_.not_modelled.other.push_back(fmt::format("limits of joint '{}', from {:g} to {:g}: at {}",
                                                      one.coordinate, range.lower, range.upper,
                                                      limit->where()));
      return;
    }
    one.ranges = {range};
    const double start = std::clamp(0.0, range.lower, range.upper);
    if (start == 0) return;
    one.q = {start};
    model_.not_modelled.motion.push_back(
        fmt::format("joint '{}' starts at {:g}, because 0 lies outside its limits: at {}", one.coordinate,
                    start, limit->where()));
  }

  void add_damping(const XmlElement& joint, const std::string& name) {
    const XmlElement* dynamics = joint.child("dynamics");
    const double damping = dynamics ? dynamics->not_negative("damping", 0) : 0;
    if (damping > 0)
      model_.scene.efforts.push_back(
          {"damping of " + name, CoordinateSpring{.on = {name}, .damping = damping}});
  }

  bool is_scalar(const std::string& joint) const {
    const auto found = joint_names_.find(joint);
    if (found == joint_names_.end()) return false;
    const std::string type = found->second->text("type");
    return type == "revolute" || type == "continuous" || type == "prismatic";
  }

  bool is_fixed(const std::string& joint) const {
    const auto found = joint_names_.find(joint);
    return found != joint_names_.end() && found->second->text("type") == "fixed";
  }

  // Starts each mimic joint where its leader is. A leader may follow another.
  void start_followers() {
    for (std::size_t pass = 0; pass < mimics_.size(); ++pass)  // (the longest chain)
      for (const Mimic& mimic : mimics_)
        *mimic.start = mimic.offset + (mimic.leader ? mimic.multiplier * *mimic.leader : 0);
  }

  // The initial value of a joint's coordinate.
  double* start_of(const std::string& joint) {
    for (Solid& solid : model_.scene.solids)
      for (Switch& one : solid.switches)
        if (one.coordinate == joint) {
          one.q.resize(1, 0);
          return one.q.data();
        }
    return nullptr;
  }

  // mimic: q = multiplier q' + offset
  void add_mimic(const XmlElement& joint) {
    const XmlElement* mimic = joint.child("mimic");
    if (!mimic) return;
    const std::string &name = joint.require("name"), &other = mimic->require("joint");
    if (is_fixed(name)) return;  // (a joint that was made fixed)
    CoordinateCoupling coupling;
    if (is_scalar(name) && is_fixed(other)) {  // then q' stays at zero
      mimic->find("multiplier");
      coupling.coordinates = {{name}};
      coupling.ratios = {1};
      coupling.value = constant(mimic->number("offset", 0));
      model_.scene.constraints.push_back({"mimic of " + name, coupling});
      mimics_.push_back({start_of(name), nullptr, 0, mimic->number("offset", 0)});
      return;
    }
    for (const std::string& end : {name, other})
      if (!is_scalar(end))
        mimic->refuse(
            fmt::format("'{}' is not a joint with one coordinate, which a <mimic> needs at both ends", end));
    coupling.coordinates = {{name}, {other}};
    coupling.ratios = {1, -mimic->number("multiplier", 1)};
    coupling.value = constant(mimic->number("offset", 0));
    model_.scene.constraints.push_back({"mimic of " + name, coupling});
    mimics_.push_back(
        {start_of(name), start_of(other), mimic->number("multiplier", 1), mimic->number("offset", 0)});
  }

  const XmlElement& root_;
  ModelFile model_;
  std::map<std::string, const XmlElement*> links_, joint_names_;
  std::vector<const XmlElement*> joints_;  // in file order
  XmlElement world_{.name = "link"};       // implied by a joint, at the place of its first mention
  std::vector<std::string> without_size_;  // places of shapes without size
  std::set<std::string> coordinates_;
  struct Mimic {
    double *start, *leader;  // initial values in the scene; leader is null if its joint is fixed
    double multiplier, offset;
  };
  std::vector<Mimic> mimics_;
};

}  // namespace

ModelFile read_urdf(const XmlElement& root, const ModelOptions& options) {
  return UrdfReader(root).read(options);
}

}  // namespace borelli
