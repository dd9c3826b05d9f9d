#include "dynamics/formats/plain_scene.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/system/coupled_switch.hpp"
#include "dynamics/system/solid_order.hpp"
#include "dynamics/system/switch_check.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The displacement by a switch at a position.
Pose displacement(const SwitchKind& kind, const std::vector<double>& q) {
  Pose X;
  move_through(kind, q.data(), X);
  return X;
}

// The position at time 0 of a driven switch.
std::vector<double> driven_start(const CheckedSwitch& one, const Driven& driven) {
  if (one.nq == 1) return {at(driven.functions[0], 0).value};
  const Vector3d theta(at(driven.functions[0], 0).value, at(driven.functions[1], 0).value,
                       at(driven.functions[2], 0).value);
  const Quaternion q = product(Quaternion(one.q[0], one.q[1], one.q[2], one.q[3]), exponential(theta));
  return {q[0], q[1], q[2], q[3]};
}

class PlainMaker {
 public:
  PlainMaker(const Scene& original, int coupling_degree, Omissions& lost)
      : original_(original), degree_(coupling_degree), lost_(lost) {}

  Result<std::unique_ptr<PlainScene>> make() {
    if (auto fine = compile(original_); !fine) return tl::unexpected(fine.error());
    auto freed = without_coupled_switches(original_);
    if (!freed) return tl::unexpected(freed.error());
    out_->scene = std::move(*freed);
    const auto ordered = order_solids(out_->scene);
    if (!ordered) return tl::unexpected(ordered.error());
    for (const std::size_t s : depth_first(ordered->order))
      if (auto done = add_solid(out_->scene.solids[s], original_.solids[s]); !done)
        return tl::unexpected(done.error());
    for (std::size_t s = 0; s < out_->solids.size(); ++s)
      for (std::size_t j = 0; j < out_->solids[s].joints.size(); ++j)
        joints_[out_->solids[s].joints[j].name] = {s, j};
    for (const Constraint& c : out_->scene.constraints)
      if (!is_stop(c) && !is_dropped_coupling(c)) out_->constraints.push_back(&c);
    for (const Effort& e : out_->scene.efforts)
      if (!is_passive(e) && !is_limit_spring(e)) out_->efforts.push_back(&e);
    return std::move(out_);
  }

 private:
  PlainJoint* joint(const std::string& coordinate) {
    const auto found = joints_.find(coordinate);
    return found == joints_.end() ? nullptr : &out_->solids[found->second.first].joints[found->second.second];
  }

  // Indices of the solids: each followed by its descendants, siblings in the scene's order.
  std::vector<std::size_t> depth_first(const std::vector<int>& parents_first) const {
    const std::vector<Solid>& solids = out_->scene.solids;
    std::map<std::string, std::vector<std::size_t>> children;
    for (const int s : parents_first)
      children[solids[static_cast<std::size_t>(s)].parent].push_back(static_cast<std::size_t>(s));
    std::vector<std::size_t> order, open;
    const auto push = [&](const std::string& parent) {
      const auto found = children.find(parent);
      if (found != children.end()) open.insert(open.end(), found->second.rbegin(), found->second.rend());
    };
    for (push(world_name); !open.empty();) {
      order.push_back(open.back());
      open.pop_back();
      push(solids[order.back()].name);
    }
    return order;
  }

  Result<void> add_solid(const Solid& solid, const Solid& original) {
    PlainSolid& plain = out_->solids.emplace_back();
    plain.source = &solid;
    const auto inertials = inertials_of(solid);
    if (!inertials) return tl::unexpected(inertials.error());
    for (const Inertial& one : *inertials) plain.inertial += one;
    Pose X;
    for (std::size_t i = 0; i < solid.switches.size(); ++i) {
      const auto checked = check_switch(solid.switches[i], out_->scene.where(solid));
      if (!checked) return tl::unexpected(checked.error());
      const std::string name = coordinate_name(solid, i);
      if (auto q = fixed_position(*checked, solid.switches[i], original.switches[i], name)) {
        X = X * displacement(checked->kind, *q);
        continue;
      }
      PlainJoint& one = plain.joints.emplace_back();
      one.name = name;
      one.before = std::exchange(X, Pose{});
      one.q = checked->q;
      one.v = checked->v;
      one.armature = solid.switches[i].armature;
      set_kind(one, checked->kind);
      set_range(one, solid.switches[i].ranges);
    }
    plain.after = X;
    return {};
  }

  // The position of a switch that is written as fixed; none: it is a joint.
  std::optional<std::vector<double>> fixed_position(const CheckedSwitch& checked, const Switch& one,
                                                    const Switch& original, const std::string& name) {
    if (checked.nv == 0) return checked.q;
    if (const auto* driven = std::get_if<Driven>(&one.motion)) {
      lost_.add("driven coordinates are fixed where they are at time 0", name);
      return driven_start(checked, *driven);
    }
    if (std::holds_alternative<Locked>(one.motion)) {
      lost_.add("locked coordinates are fixed, not joints", name);
      return checked.q;
    }
    if (!std::holds_alternative<Rotation>(one.kind) && !std::holds_alternative<Translation>(one.kind) &&
        !std::holds_alternative<Ball>(one.kind)) {
      lost_.add(fmt::format("{} switches are fixed at their start", checked.kind_name), name);
      return checked.q;
    }
    const auto* coupled = std::get_if<Coupled>(&original.motion);
    if (coupled && !polynomial(coupled->function, degree_)) {
      lost_.add(degree_ == 1 ? "coordinates coupled by other functions than straight lines are fixed at "
                               "their start"
                             : fmt::format("coordinates coupled by other functions than polynomials of "
                                           "degree {} are fixed at their start",
                                           degree_),
                name);
      dropped_.push_back(name);
      return checked.q;
    }
    return std::nullopt;
  }

  static void set_kind(PlainJoint& one, const SwitchKind& kind) {
    if (const auto* hinge = std::get_if<Rotation>(&kind)) {
      one.axis = hinge->axis;
    } else if (const auto* slide = std::get_if<Translation>(&kind)) {
      one.kind = PlainJoint::Kind::slide;
      one.axis = slide->axis;
    } else {
      one.kind = PlainJoint::Kind::ball;
    }
  }

  void set_range(PlainJoint& one, const std::vector<Range>& ranges) {
    if (ranges.empty()) return;
    if (one.kind == PlainJoint::Kind::ball)
      lost_.add("ranges of balls are not written", one.name);
    else if (!(ranges[0].lower < ranges[0].upper))
      lost_.add("ranges without width are not written", one.name);
    else
      one.range = ranges[0];
  }

  // ---- constraints ----

  // Whether a range has a width and holds the joint's start.
  static bool bounds(const PlainJoint& one, const Range& range) {
    return range.lower < range.upper && range.holds(one.q[0]);
  }

  // A stop is the range of its joint.
  bool is_stop(const Constraint& constraint) {
    const auto* stop = std::get_if<Limit>(&constraint.kind);
    PlainJoint* on = stop ? joint(stop->on.coordinate) : nullptr;
    if (!on || !stop->lower || !stop->upper || !bounds(*on, {*stop->lower, *stop->upper})) return false;
    on->range = Range{*stop->lower, *stop->upper};
    lost_.add("stops are ranges of their joints, without their restitution", constraint.name);
    return true;
  }

  bool is_dropped_coupling(const Constraint& constraint) const {
    const auto* tie = std::get_if<CoordinateFunction>(&constraint.kind);
    return tie && std::find(dropped_.begin(), dropped_.end(), tie->on.coordinate) != dropped_.end() &&
           &constraint >= out_->scene.constraints.data() + original_.constraints.size();
  }

  // ---- efforts ----

  bool is_limit_spring(const Effort& effort) {
    const auto* spring = std::get_if<LimitSpring>(&effort.kind);
    PlainJoint* on = spring ? joint(spring->on.coordinate) : nullptr;
    if (!on || on->kind == PlainJoint::Kind::ball) return false;
    if (!on->range && !spring->range.empty() && bounds(*on, spring->range[0])) on->range = spring->range[0];
    if (!on->range) return false;
    lost_.add("springs at limits are ranges of their joints, without their stiffness and losses",
              effort.name);
    return true;
  }

  // Adds springs and dampers to their joint.
  bool is_passive(const Effort& effort) {
    if (const auto* spring = std::get_if<CoordinateSpring>(&effort.kind))
      return add_scalar(joint(spring->on.coordinate), spring->stiffness, spring->damping, spring->rest);
    if (const auto* controller = std::get_if<PdController>(&effort.kind)) return add_controller(*controller);
    if (const auto* spring = std::get_if<TorsionSpring>(&effort.kind)) return add_torsion(*spring);
    return false;
  }

  static bool add_scalar(PlainJoint* on, double stiffness, double damping, double rest) {
    if (!on || on->kind == PlainJoint::Kind::ball || stiffness < 0 || damping < 0) return false;
    on->stiffness += stiffness;
    on->damping += damping;
    on->pull += stiffness * rest;
    return true;
  }

  static bool add_ball(PlainJoint& on, double stiffness, double damping, const Quaternion& rest) {
    if (stiffness < 0 || damping < 0) return false;
    if (stiffness > 0 && on.rest && (rotation_matrix(*on.rest) - rotation_matrix(rest)).norm() > 1e-14)
      return false;  // two springs with different rests are not one
    if (stiffness > 0) on.rest = rest;
    on.stiffness += stiffness;
    on.damping += damping;
    return true;
  }

  // A controller with a constant target is a spring and damper.
  bool add_controller(const PdController& controller) {
    PlainJoint* on = joint(controller.on.coordinate);
    Vector3d target = Vector3d::Zero();
    for (std::size_t i = 0; i < controller.target.size(); ++i) {
      const auto value = polynomial(controller.target[i], 0);
      if (!value) return false;
      target[static_cast<Eigen::Index>(i)] = value->at(0);
    }
    if (!on || (on->kind == PlainJoint::Kind::ball) != (controller.target.size() == 3)) return false;
    if (on->kind == PlainJoint::Kind::ball)
      return add_ball(*on, controller.kp, controller.kd, exponential(target));
    return add_scalar(on, controller.kp, controller.kd, target[0]);
  }

  // A torsion spring between a solid and its parent is a ball's if nothing else turns between them.
  bool add_torsion(const TorsionSpring& spring) {
    for (PlainSolid& solid : out_->solids) {
      const std::string &child = solid.source->name, &parent = solid.source->parent;
      const bool forwards = spring.a.solid == child && spring.b.solid == parent;
      const bool backwards = spring.a.solid == parent && spring.b.solid == child;
      if (!forwards && !backwards) continue;
      PlainJoint* ball = nullptr;
      Matrix3d R_before = Matrix3d::Identity(), R_after = Matrix3d::Identity();
      for (PlainJoint& one : solid.joints) {
        (ball ? R_after : R_before) *= one.before.R;
        if (one.kind == PlainJoint::Kind::slide) continue;
        if (ball || one.kind == PlainJoint::Kind::hinge) return false;
        ball = &one;
      }
      R_after *= solid.after.R;
      if (!ball) return false;
      const Matrix3d R_rest = rotation_matrix(exponential(Vector3d(forwards ? spring.rest : -spring.rest)));
      return add_ball(*ball, spring.stiffness, spring.damping,
                      quaternion(R_before.transpose() * R_rest * R_after.transpose()));
    }
    return false;
  }

  const Scene& original_;
  const int degree_;
  Omissions& lost_;
  std::unique_ptr<PlainScene> out_ = std::make_unique<PlainScene>();
  std::map<std::string, std::pair<std::size_t, std::size_t>> joints_;  // solid and joint, by coordinate
  std::vector<std::string> dropped_;  // coordinates whose coupling is not written
};

}  // namespace

Pose PlainJoint::displaced(const std::vector<double>& position) const {
  switch (kind) {
    case Kind::hinge:
      return displacement(Rotation{axis}, position);
    case Kind::slide:
      return displacement(Translation{axis}, position);
    case Kind::ball:
      return displacement(Ball{}, position);
  }
  return {};
}

const PlainJoint* PlainScene::joint(const std::string& coordinate) const {
  for (const PlainSolid& solid : solids)
    for (const PlainJoint& one : solid.joints)
      if (one.name == coordinate) return &one;
  return nullptr;
}

std::optional<std::vector<double>> polynomial(const TimeFunction& f, int degree) {
  const auto* given = std::get_if<Polynomial>(&f);
  if (!given) return std::nullopt;
  std::vector<double> out = given->coefficients;
  const auto size = static_cast<std::size_t>(degree) + 1;
  if (std::any_of(out.begin() + static_cast<std::ptrdiff_t>(std::min(size, out.size())), out.end(),
                  [](double c) { return c != 0; }))
    return std::nullopt;
  out.resize(size, 0);
  return out;
}

std::string free_joint_name(const PlainSolid& solid) {
  const auto& joints = solid.joints;
  const auto at_origin = [](const Pose& X) { return X.R.isIdentity(0) && X.p.isZero(0); };
  if (joints.size() != 4 || joints[3].kind != PlainJoint::Kind::ball || !at_origin(solid.after)) return "";
  for (std::size_t i = 0; i < 4; ++i) {
    const PlainJoint& one = joints[i];
    if (one.stiffness != 0 || one.damping != 0 || one.range || (i > 0 && !at_origin(one.before))) return "";
    if (i < 3 &&
        (one.kind != PlainJoint::Kind::slide || one.axis != Vector3d::Unit(static_cast<Eigen::Index>(i))))
      return "";
  }
  const std::string& first = joints[0].name;
  const bool has_part = first.size() > 2 && (first.ends_with(".x") || first.ends_with("_x"));
  return has_part ? first.substr(0, first.size() - 2) : solid.source->name;
}

void list_renamed(const PlainSolid& solid, const std::string& free_joint, Omissions& lost) {
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string name = free_joint + (i == 3 ? ".turn" : std::string(".") + "xyz"[i]);
    if (solid.joints[i].name != name)
      lost.add("coordinates of free joints are named after the joint",
               fmt::format("{} is {}", solid.joints[i].name, name));
  }
}

Result<std::unique_ptr<PlainScene>> plain_scene(const Scene& scene, int coupling_degree, Omissions& lost) {
  return PlainMaker(scene, coupling_degree, lost).make();
}

}  // namespace borelli
