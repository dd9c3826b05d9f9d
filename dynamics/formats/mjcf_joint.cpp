#include "dynamics/formats/mjcf_joint.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/scene/free_joint.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void add_fixed(Solid& solid, const Pose& X) {
  if (X.R.isIdentity(0) && X.p.isZero(0)) return;
  solid.switches.emplace_back().kind = Fixed{X};
}

Vector3d axis_of(const XmlElement& joint) {
  const Vector3d axis = joint.vector("axis", Vector3d::UnitZ());
  if (axis.norm() < 1e-10) joint.refuse("axis", "axis has no direction");
  return axis.normalized();
}

bool has_type(const XmlElement& joint, std::string_view type) {
  return joint.name == "freejoint" ? type == "free" : joint.text("type", "hinge") == type;
}

// Whether the switches of a solid so far rotate it against its parent.
bool turns(const Solid& solid) {
  return std::any_of(solid.switches.begin(), solid.switches.end(), [](const Switch& s) {
    return std::visit([](const auto& kind) { return kind.rotates; }, s.kind);
  });
}

// The rotation of a solid in its parent by its fixed switches, at the start of its free rotations.
Matrix3d fixed_turn(const Solid& solid) {
  Matrix3d R = Matrix3d::Identity();
  for (const Switch& s : solid.switches)
    if (const auto* fixed = std::get_if<Fixed>(&s.kind)) R = (R * fixed->X_AB.R).eval();
  return R;
}

}  // namespace

void MjcfJoints::take_names(const XmlElement& parent) {
  for (const XmlElement& c : parent.children) {
    if (c.name == "body") take_names(c);
    if (c.name != "joint" && c.name != "freejoint") continue;
    const std::string name = c.text("name");
    if (!name.empty() && !named_.try_emplace(name).second)
      c.refuse("there are two joints of this name; rename one");
    names_.take(name);
  }
}

std::string MjcfJoints::name_of(const XmlElement& joint, const Solid& solid) {
  const std::string given = joint.text("name");
  return given.empty() ? names_.make(solid.name) : given;
}

MjcfJoints::Passive MjcfJoints::passive_of(const XmlElement& joint) const {
  const double stiffness = linear(joint, "stiffness"), damping = linear(joint, "damping");
  return {acting_.springs ? stiffness : 0, acting_.dampers ? damping : 0};
}

// The linear coefficient of a polynomial; a note reports higher ones.
double MjcfJoints::linear(const XmlElement& joint, const char* key) const {
  const auto given = joint.numbers(key, 1, 3);
  if (given.empty()) return 0;
  if (given[0] < 0) joint.refuse(key, fmt::format("{} is {:g}, expected 0 or more", key, given[0]));
  if (std::any_of(given.begin() + 1, given.end(), [](double c) { return c != 0; }))
    notes_.push_back(fmt::format("the nonlinear part of {} of <joint>: at {}", key, joint.where()));
  return given[0];
}

void MjcfJoints::read(const XmlElement& body, const Pose& X_PS, Solid& solid, std::vector<Solid>& before,
                      std::vector<Effort>& efforts) {
  std::vector<const XmlElement*> joints;
  for (const XmlElement& c : body.children)
    if (c.name == "joint" || c.name == "freejoint") joints.push_back(&c);
  const auto free =
      std::find_if(joints.begin(), joints.end(), [](const XmlElement* j) { return has_type(*j, "free"); });
  if (free != joints.end()) {
    if (joints.size() > 1) (*free)->refuse("a free joint must be the only joint of its body");
    if (solid.parent != world_name) (*free)->refuse("a free joint's body must be a child of <worldbody>");
    note_alignment(body, **free);
    return read_free(**free, X_PS, solid, efforts);
  }
  add_fixed(solid, X_PS);
  for (auto at = joints.begin(); at != joints.end(); ++at) {
    const XmlElement* joint = *at;
    joint->read = true;
    joint->find("class");
    const std::string type = joint->word("type", {"free", "ball", "hinge", "slide"}, "hinge");
    const Vector3d anchor = joint->vector("pos", Vector3d::Zero());
    if (type == "slide") {
      read_scalar(*joint, type, solid, efforts);
      continue;
    }
    add_fixed(solid, {Matrix3d::Identity(), anchor});
    if (type == "hinge") read_scalar(*joint, type, solid, efforts);
    if (type == "ball") {
      if (std::any_of(at + 1, joints.end(), [](const XmlElement* j) { return !has_type(*j, "slide"); }))
        joint->refuse("a ball must be the last rotating joint of a body, as in MuJoCo");
      read_ball(*joint, solid, before, efforts);
    }
    add_fixed(solid, {Matrix3d::Identity(), -anchor});
  }
}

// MuJoCo's condition for moving the body frame to the inertia (mjCBody::Compile).
void MjcfJoints::note_alignment(const XmlElement& body, const XmlElement& joint) {
  const std::string align = joint.word("align", {"true", "false", "auto"}, "auto");
  const bool asked = align == "true" || (align == "auto" && compilers_.of(joint).align_free);
  const bool leaf = std::none_of(body.children.begin(), body.children.end(),
                                 [](const XmlElement& c) { return c.name == "body"; });
  if (asked && leaf && aligned_count_++ == 0) first_aligned_ = joint.where();
}

std::string MjcfJoints::aligned() const {
  if (aligned_count_ == 0) return "";
  return fmt::format(
      "alignment of {} free joints (align, alignfree): MuJoCo's qpos refers to the inertia's frame, this "
      "scene's to the body's: first at {}",
      aligned_count_, first_aligned_);
}

void MjcfJoints::read_free(const XmlElement& joint, const Pose& X_WS, Solid& solid,
                           std::vector<Effort>& efforts) {
  joint.read = true;
  for (const char* key : {"class", "type", "pos", "axis"}) joint.find(key);
  const std::string name = name_of(joint, solid);
  solid.switches = free_joint(name, X_WS);
  for (Switch& s : solid.switches) s.coordinate = names_.make(s.coordinate);
  if (joint.name == "freejoint") return;  // (takes no defaults)
  for (Switch& s : solid.switches) s.armature = joint.not_negative("armature", 0);
  const Passive passive = passive_of(joint);
  if (!passive.any()) return;
  for (int i = 0; i < 3; ++i) {
    const std::string& slide = solid.switches[static_cast<std::size_t>(i)].coordinate;
    efforts.push_back(
        {"passive of " + slide, CoordinateSpring{{slide}, passive.stiffness, passive.damping, X_WS.p[i]}});
  }
  efforts.push_back(
      {"passive of " + solid.switches[3].coordinate, TorsionSpring{.a = {solid.name},
                                                                   .b = {world_name},
                                                                   .stiffness = passive.stiffness,
                                                                   .damping = passive.damping,
                                                                   .rest = logarithm(quaternion(X_WS.R))}});
}

void MjcfJoints::read_scalar(const XmlElement& joint, const std::string& type, Solid& solid,
                             std::vector<Effort>& efforts) {
  const bool hinge = type == "hinge";
  if (!hinge) joint.find("pos");  // a slide has none
  const Vector3d axis = axis_of(joint);
  const auto position = [&](const char* key) {
    const double value = joint.number(key, 0);
    return hinge ? compilers_.of(joint).angle(value) : value;
  };
  const double ref = position("ref"), spring_ref = position("springref");
  if (ref != 0)
    add_fixed(solid, hinge ? Pose{rotation_about(axis, -ref), Vector3d::Zero()}
                           : Pose{Matrix3d::Identity(), -ref * axis});
  Switch one;
  one.kind = hinge ? SwitchKind(Rotation{axis}) : SwitchKind(Translation{axis});
  one.coordinate = name_of(joint, solid);
  if (ref != 0) one.q = {ref};
  one.armature = joint.not_negative("armature", 0);
  add_range(joint, hinge, one);
  if (const std::string given = joint.text("name"); !given.empty()) named_[given] = {one.coordinate, ref};
  if (const Passive p = passive_of(joint); p.any())
    efforts.push_back({"passive of " + one.coordinate,
                       CoordinateSpring{{one.coordinate}, p.stiffness, p.damping, spring_ref}});
  solid.switches.push_back(std::move(one));
}

// A spring between two solids sees all rotations between them. So hinges before the ball go to a solid of
// their own.
void MjcfJoints::read_ball(const XmlElement& joint, Solid& solid, std::vector<Solid>& before,
                           std::vector<Effort>& efforts) {
  joint.find("axis");  // a ball has none
  const std::string name = name_of(joint, solid);
  const Passive passive = passive_of(joint);
  if (passive.any() && turns(solid)) {
    Solid& inner = before.emplace_back();
    inner.name = solid_names.make("before " + name);
    inner.parent = solid.parent;
    inner.switches = std::move(solid.switches);
    solid.switches.clear();
    solid.parent = inner.name;
  }
  if (passive.any())
    efforts.push_back(
        {"passive of " + name, TorsionSpring{.a = {solid.name},
                                             .b = {solid.parent},
                                             .stiffness = passive.stiffness,
                                             .damping = passive.damping,
                                             .rest = logarithm(quaternion(fixed_turn(solid)))}});
  Switch& ball = solid.switches.emplace_back();
  ball.kind = Ball{};
  ball.coordinate = name;
  ball.armature = joint.not_negative("armature", 0);
}

// The limits of a scalar joint. A start outside is moved to the nearest limit, since compile() would refuse
// it.
void MjcfJoints::add_range(const XmlElement& joint, bool hinge, Switch& one) {
  const auto range = joint.numbers("range", 2, 2);
  const std::string limited = joint.word("limited", {"true", "false", "auto"}, "auto");
  const MjcfCompiler& compiler = compilers_.of(joint);
  const bool none = range.empty() || (range[0] == 0 && range[1] == 0);
  if (limited == "false" || (limited == "auto" && (none || !compiler.auto_limits))) return;
  if (range.empty()) joint.refuse("is limited but has no range");
  const Range limits =
      hinge ? Range{compiler.angle(range[0]), compiler.angle(range[1])} : Range{range[0], range[1]};
  if (!(limits.lower < limits.upper))
    joint.refuse("range", fmt::format("range runs from {:g} to {:g}; the lower bound must come first",
                                      range[0], range[1]));
  if (!acting_.limits) return;
  one.ranges = {limits};
  const double start = one.q.empty() ? 0 : one.q[0];
  const double allowed = std::clamp(start, limits.lower, limits.upper);
  if (allowed == start) return;
  one.q = {allowed};
  notes_.push_back(fmt::format("joint '{}' starts at {:.6g}, because {:.6g} lies outside its range: at {}",
                               one.coordinate, allowed, start, joint.where()));
}

}  // namespace borelli
