#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "dynamics/formats/mjcf_draft.hpp"
#include "dynamics/formats/mjcf_site.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using JointKind = PlainJoint::Kind;

// MuJoCo refuses moving bodies with less mass or moments of inertia (mjMINVAL): kg, kg m^2.
constexpr double least_inertia = 1e-15;

// The joints of one body, and the pose of its frame behind the last one.
struct BodyPart {
  std::vector<const PlainJoint*> joints;
  Pose after;
};

// Cuts the joints of a solid behind a ball that another rotation follows: in MuJoCo a ball is the last one.
std::vector<BodyPart> parts_of(const PlainSolid& solid) {
  std::vector<BodyPart> out(1);
  for (std::size_t j = 0; j < solid.joints.size(); ++j) {
    out.back().joints.push_back(&solid.joints[j]);
    if (solid.joints[j].kind != JointKind::ball) continue;
    const bool last =
        std::all_of(solid.joints.begin() + static_cast<std::ptrdiff_t>(j) + 1, solid.joints.end(),
                    [](const PlainJoint& later) { return later.kind == JointKind::slide; });
    if (!last) out.emplace_back();
  }
  out.back().after = solid.after;
  return out;
}

class MjcfWriter {
 public:
  MjcfWriter(const PlainScene& plain, const ModelExtras& extras, Omissions& lost)
      : extras_(extras), draft_{.plain = plain, .lost = lost} {
    for (const Constraint* c : plain.constraints)
      has_loops_ = has_loops_ || std::holds_alternative<PointOnPoint>(c->kind);
    for (const PlainSolid& solid : plain.solids) {
      draft_.solids.take(solid.source->name);
      for (const PlainJoint& one : solid.joints) joint_names_.take(one.name);
    }
  }

  Result<std::string> write() {
    draft_.bodies[world_name] = &draft_.world;
    draft_.poses[world_name] = Pose{};
    draft_.still[world_name] = true;
    depth_[world_name] = 2;
    for (const PlainSolid& solid : draft_.plain.solids) {
      if (auto done = add_solid(solid); !done) return tl::unexpected(done.error());
    }
    add_mjcf_shapes(draft_, extras_.meshes);
    add_mjcf_constraints(draft_);
    add_mjcf_sites(draft_);
    for (const ModelFrame& frame : extras_.frames)
      if (const auto body = draft_.bodies.find(frame.solid); body != draft_.bodies.end())
        set_place(body->second->add("site").set("name", draft_.sites.make(frame.name)), frame.pose);
    return finished();
  }

 private:
  Result<void> add_solid(const PlainSolid& solid) {
    const std::string &name = solid.source->name, &parent = solid.source->parent;
    if (name == "worldbody" && parent == world_name && solid.source->switches.empty() &&
        solid.inertial.mass == 0) {  // our reader's solid of the world's shapes
      draft_.bodies[name] = &draft_.world;
      draft_.poses[name] = Pose{};
      draft_.still[name] = true;
      depth_[name] = depth_.at(parent);
      return {};
    }
    const std::vector<BodyPart> parts = parts_of(solid);
    depth_[name] = depth_.at(parent) + static_cast<int>(parts.size());
    if (depth_[name] + 1 > deepest_xml)
      return bad_use(
          draft_.plain.scene.where(*solid.source),
          fmt::format("lies more than {} solids deep, the limit of nested elements in MJCF", deepest_xml));
    XmlNode* body = draft_.bodies.at(parent);
    Pose X = draft_.poses.at(parent);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const bool last = i + 1 == parts.size();
      body = &body->add("body");
      body->set(
          "name",
          last ? name : draft_.solids.make(fmt::format("{} at {}", name, parts[i].joints.back()->name)));
      X = X * add_joints(*body, solid, parts[i]);
      add_inertial(*body, last ? solid.inertial : Inertial{}, !parts[i].joints.empty(), name);
    }
    draft_.bodies[name] = body;
    draft_.poses[name] = X;
    draft_.still[name] = solid.joints.empty() && draft_.still.at(parent);
    return {};
  }

  // Writes the pose and joints of a body, and returns its pose in the parent at the start.
  //
  // With T the pose of the body in the frame behind a joint, the joint's displacement D from its start acts
  // on the body as T^-1 D T: its axis and anchor in the body are those of T^-1.
  Pose add_joints(XmlNode& body, const PlainSolid& solid, const BodyPart& part) {
    if (const std::string name = free_name(solid); !name.empty()) return add_free(body, part, name);
    std::vector<Pose> behind(part.joints.size());
    Pose T = part.after;
    for (std::size_t i = part.joints.size(); i-- > 0;) {
      const PlainJoint& one = *part.joints[i];
      behind[i] = T;
      T = one.before * one.displaced(zero_of(one)) * T;
    }
    set_place(body, T);
    for (std::size_t i = 0; i < part.joints.size(); ++i) add_joint(body, *part.joints[i], behind[i]);
    return T;
  }

  void add_joint(XmlNode& body, const PlainJoint& one, const Pose& T) {
    XmlNode& node = body.add("joint");
    node.set("name", one.name);
    const bool ball = one.kind == JointKind::ball;
    node.set("type", ball ? "ball" : one.kind == JointKind::slide ? "slide" : "hinge");
    const Vector3d anchor = T.inverse().p;
    if (one.kind != JointKind::slide && !anchor.isZero(0)) node.set("pos", anchor);
    if (!ball) {
      node.set("axis", Vector3d(T.R.transpose() * one.axis));
      if (one.q[0] != 0) node.set("ref", one.q[0]);
      draft_.refs[one.name] = one.q[0];
      if (one.range)
        node.set("limited", "true").set("range", std::vector{one.range->lower, one.range->upper});
    }
    if (one.armature > 0) node.set("armature", one.armature);
    const bool springs = one.stiffness > 0 && (!ball || keeps_rest(one));
    if (springs) node.set("stiffness", one.stiffness);
    if (springs && !ball && one.pull != 0) node.set("springref", one.pull / one.stiffness);
    if (one.stiffness > 0 && !springs)
      draft_.lost.add("springs of balls that do not start at rest are not written beside loops", one.name);
    if (one.damping > 0) node.set("damping", one.damping);
    const std::vector<double> zero = zero_of(one);
    start_.insert(start_.end(), one.q.begin(), one.q.end());
    model_.insert(model_.end(), zero.begin(), zero.end());
    if (ball) {
      if (!T.R.isIdentity(0))
        draft_.lost.add("balls are counted in the axes of their solids, not in their own", one.name);
      Quaternion q = identity_quaternion();
      if (zero != one.q) {
        const Quaternion turn = quaternion(T.R),
                         own = product(conjugate(quaternion_of(zero)), quaternion_of(one.q));
        q = product(product(conjugate(turn), own), turn);
      }
      std::copy(q.begin(), q.end(), start_.end() - 4);
      const Quaternion identity = identity_quaternion();
      std::copy(identity.begin(), identity.end(), model_.end() - 4);
    }
    if (ball) {
      const Vector3d rate = T.R.transpose() * Vector3d(one.v[0], one.v[1], one.v[2]);
      rates_.insert(rates_.end(), rate.begin(), rate.end());
    } else {
      rates_.push_back(one.v[0]);
    }
  }

  static Quaternion quaternion_of(const std::vector<double>& q) { return {q[0], q[1], q[2], q[3]}; }

  bool keeps_rest(const PlainJoint& ball) const {
    return !has_loops_ ||
           (rotation_matrix(*ball.rest) - rotation_matrix(quaternion_of(ball.q))).norm() < 1e-14;
  }

  // The position where MuJoCo's model stands. Of a hinge or slide it is the start (`ref`). A ball stands at
  // its own identity there, which is its spring's rest; without a spring we choose its start. Loops close in
  // the model's pose, so there all balls start.
  std::vector<double> zero_of(const PlainJoint& one) const {
    if (one.kind != JointKind::ball || one.stiffness == 0 || has_loops_) return one.q;
    return {one.rest->begin(), one.rest->end()};
  }

  // The name of a solid's free joint, which must be a child of the world. Empty: it has other joints.
  std::string free_name(const PlainSolid& solid) {
    const std::string name = free_joint_name(solid);
    if (name.empty() || solid.source->parent != world_name) return "";
    const PlainJoint& first = solid.joints[0];
    if (!first.before.R.isIdentity(0) || !first.before.p.isZero(0)) return "";
    for (const PlainJoint& one : solid.joints)
      if (one.armature != first.armature) return "";
    if (!joint_names_.take(name)) return "";
    list_renamed(solid, name, draft_.lost);
    return name;
  }

  Pose add_free(XmlNode& body, const BodyPart& part, const std::string& name) {
    Pose X;
    for (const PlainJoint* one : part.joints) {
      X = X * one->displaced(one->q);
      start_.insert(start_.end(), one->q.begin(), one->q.end());
      rates_.insert(rates_.end(), one->v.begin(), one->v.end());
      model_.insert(model_.end(), one->q.begin(), one->q.end());
    }
    set_place(body, X);
    XmlNode& node = body.add(part.joints[0]->armature > 0 ? "joint" : "freejoint");
    node.set("name", name);
    if (part.joints[0]->armature > 0) node.set("type", "free").set("armature", part.joints[0]->armature);
    return X;
  }

  // Writes principal axes: MuJoCo finds those of a full tensor to 1e-9 only.
  void add_inertial(XmlNode& body, Inertial own, bool moves, const std::string& solid) {
    if (!moves && own.mass == 0) return;
    if (moves && own.mass < least_inertia) {
      own.mass = least_inertia;
      draft_.lost.add("moving bodies without mass get 1e-15 kg and 1e-15 kg m^2, which MuJoCo needs", solid);
    }
    const bool diagonal = own.tensor.isDiagonal(0);
    const PrincipalAxes principal = own.principal();
    Vector3d moments = diagonal ? Vector3d(own.tensor.diagonal()) : principal.moments;
    if (moves && moments.minCoeff() < least_inertia) {
      if (own.mass > least_inertia)
        draft_.lost.add("moments of inertia below 1e-15 kg m^2 become that, which MuJoCo needs", solid);
      moments = moments.cwiseMax(least_inertia);
    }
    for (int i = 0; i < 3; ++i)  // flat bodies: rounding must not break the triangle inequality
      moments[i] = std::min(moments[i], moments[(i + 1) % 3] + moments[(i + 2) % 3]);
    XmlNode& node = body.add("inertial");
    node.set("pos", own.centre);
    if (!diagonal) {
      const Quaternion q = quaternion(principal.axes);
      node.set("quat", std::vector<double>(q.begin(), q.end()));
    }
    node.set("mass", own.mass).set("diaginertia", moments);
  }

  std::string finished() {
    const Scene& scene = draft_.plain.scene;
    XmlNode& root = draft_.root;
    root.set("model", scene.name);
    for (const std::string& line : extras_.comments) root.comment(line);
    if (!scene.description.empty()) root.comment(scene.description);
    for (const std::string& line : draft_.lost.sentences()) root.comment("Lost or changed: " + line);
    root.add("compiler").set("angle", "radian").set("inertiafromgeom", "false");
    XmlNode& option = root.add("option");
    option.set("gravity", scene.gravity).set("timestep", scene.simulation.step);
    if (draft_.contact.children.empty()) option.set("integrator", "RK4");
    for (XmlNode* section : {&draft_.asset, &draft_.world, &draft_.contact, &draft_.tendon, &draft_.equality})
      if (section == &draft_.world || !section->children.empty())
        root.children.push_back(std::move(*section));
    const bool at_rest = std::all_of(rates_.begin(), rates_.end(), [](double v) { return v == 0; });
    if (!at_rest || start_ != model_) {
      root.add("keyframe").add("key").set("name", mjcf_start).set("qpos", start_).set("qvel", rates_);
    }
    return xml_text(root);
  }

  const ModelExtras& extras_;
  MjcfDraft draft_;
  UniqueNames joint_names_;
  bool has_loops_ = false;
  std::map<std::string, int> depth_;           // of the solids' elements in the document
  std::vector<double> start_, model_, rates_;  // qpos at the start, that of the model's pose; qvel
};

}  // namespace

void set_place(XmlNode& node, const Pose& X) {
  if (!X.p.isZero(0)) node.set("pos", X.p);
  if (X.R.isIdentity(0)) return;
  const Quaternion q = quaternion(X.R);
  node.set("quat", std::vector<double>(q.begin(), q.end()));
}

Result<WrittenModel> write_mjcf(const Scene& scene, const ModelExtras& extras) {
  Omissions lost;
  const auto plain = plain_scene(scene, 4, lost);
  if (!plain) return tl::unexpected(plain.error());
  list_run_settings(scene.simulation, lost);
  auto text = MjcfWriter(**plain, extras, lost).write();
  if (!text) return tl::unexpected(text.error());
  return WrittenModel{std::move(*text), lost.sentences()};
}

}  // namespace borelli
