#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/plain_scene.hpp"
#include "dynamics/formats/unique_names.hpp"
#include "dynamics/formats/xml_text.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using LinkJoint = PlainJoint::Kind;

// kg, kg m^2: simulators refuse moving links without inertia, or drop them.
constexpr double least_link_inertia = 1e-15;
// N, N m, m/s, rad/s, m: bounds that URDF demands and a scene does not have
constexpr double unbounded = 1e6;

// Angles about fixed x, y, z whose rotation is R. Yaw comes first, so that roll is exact at a pitch of a
// right angle too, where yaw is arbitrary.
Vector3d roll_pitch_yaw(const Matrix3d& R) {
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const Matrix3d rest = rotation_about(Vector3d::UnitZ(), -yaw) * R;
  return {std::atan2(-rest(1, 2), rest(1, 1)), std::atan2(-rest(2, 0), rest(0, 0)), yaw};
}

void add_origin(XmlNode& node, const Pose& X) {
  if (X.p.isZero(0) && X.R.isIdentity(0)) return;
  XmlNode& origin = node.add("origin");
  origin.set("xyz", X.p);
  if (!X.R.isIdentity(0)) origin.set("rpy", roll_pitch_yaw(X.R));
}

class UrdfWriter {
 public:
  UrdfWriter(const PlainScene& plain, const ModelExtras& extras, Omissions& lost)
      : plain_(plain), extras_(extras), lost_(lost) {}

  std::string write() {
    take_names();
    root_.set("name", plain_.scene.name.empty() ? "scene" : plain_.scene.name);
    for (const std::string& line : extras_.comments) root_.comment(line);
    if (!plain_.scene.description.empty()) root_.comment(plain_.scene.description);
    const std::size_t losses_at = root_.children.size();
    // else MuJoCo adds the tensors of welded links, and seeks the axes of the sum: to 1e-7 of the mass matrix
    root_.add("mujoco").add("compiler").set("fusestatic", "false");
    links_[world_name] = &root_.add("link").set("name", world_name);
    for (const PlainSolid& solid : plain_.solids) add_solid(solid);
    add_meshes();
    add_markers();
    for (const Constraint* constraint : plain_.constraints) add_constraint(*constraint);
    for (const Effort* effort : plain_.efforts)
      lost_.add("efforts are not written", named_with_kind(*effort));
    list_settings();
    XmlNode losses;
    for (const std::string& line : lost_.sentences()) losses.comment("Lost or changed: " + line);
    root_.children.splice(std::next(root_.children.begin(), static_cast<std::ptrdiff_t>(losses_at)),
                          losses.children);
    return xml_text(root_);
  }

 private:
  // ROS takes names of links as names of frames, which have neither blanks nor slashes.
  std::string valid(const std::string& name) {
    std::string out = name;
    for (char& c : out)
      if (c == ' ' || c == '\t' || c == '\n' || c == '/') c = '_';
    return out;
  }

  std::string renamed(UniqueNames& names, const std::string& name) {
    std::string out = valid(name);
    while (!names.take(out)) out += "_";
    if (out != name) lost_.add("names that URDF cannot hold are changed", fmt::format("{} is {}", name, out));
    return out;
  }

  void take_names() {
    link_names_.take(world_name);
    for (const PlainSolid& solid : plain_.solids) {
      link_of_[solid.source->name] = renamed(link_names_, solid.source->name);
      for (const PlainJoint& one : solid.joints) joint_of_[one.name] = renamed(joint_names_, one.name);
    }
    link_of_[world_name] = world_name;
  }

  XmlNode& add_link(const std::string& name) { return root_.add("link").set("name", name); }

  XmlNode& add_joint(const std::string& name, const char* type, const std::string& parent,
                     const std::string& child, const Pose& X) {
    XmlNode& joint = root_.add("joint");
    joint.set("name", name).set("type", type);
    add_origin(joint, X);
    joint.add("parent").set("link", parent);
    joint.add("child").set("link", child);
    return joint;
  }

  // ---- solids ----

  // A chain of links, one per coordinate; the last is the solid.
  void add_solid(const PlainSolid& given) {
    const PlainSolid solid = without_end(given);
    const std::string &name = solid.source->name, link = link_of_.at(name);
    std::string parent = link_of_.at(solid.source->parent);
    const bool ends = at_origin(solid.after);
    if (const std::string free = free_name(given); !free.empty()) {
      add_joint(free, "floating", parent, link, given.joints[0].before);
      note_start(given, free);
    } else {
      for (std::size_t j = 0; j < solid.joints.size(); ++j) {
        const PlainJoint& one = solid.joints[j];
        const bool last = ends && j + 1 == solid.joints.size();
        parent = one.kind == LinkJoint::ball ? add_ball(one, parent, last ? link : "")
                                             : add_scalar(one, parent, last ? link : "");
      }
      if (!ends || solid.joints.empty())
        add_joint(joint_names_.make(link + "_fixed"), "fixed", parent, link, solid.after);
    }
    XmlNode& node = add_link(link);
    links_[name] = &node;
    add_inertial(node, solid.inertial, !solid.joints.empty() && ends, name);
    for (const ShapeElement& element : solid.source->shapes) add_shape(node, element.shape, name);
  }

  static bool at_origin(const Pose& X) { return X.p.isZero(0) && X.R.isIdentity(0); }

  // The placement behind the last joint put before it: D F = F (F^-1 D F). A turn about a line is one about
  // the line's place from behind, which must run through the link's origin: so behind a hinge or ball F may
  // only rotate.
  static PlainSolid without_end(PlainSolid solid) {
    if (solid.joints.empty()) return solid;
    PlainJoint& last = solid.joints.back();
    if (last.kind != LinkJoint::slide && !solid.after.p.isZero(0)) return solid;
    last.before = last.before * solid.after;
    last.axis = solid.after.R.transpose() * last.axis;
    last.own_axes = solid.after.R.transpose();
    solid.after = Pose{};
    return solid;
  }

  // The name of a solid's free joint. Empty: it has other joints.
  std::string free_name(const PlainSolid& solid) {
    std::string name = free_joint_name(solid);
    if (name.empty() || valid(name) != name || !joint_names_.take(name)) return "";
    list_renamed(solid, name, lost_);
    return name;
  }

  void note_start(const PlainSolid& solid, const std::string& free) {
    const bool at_zero = std::all_of(solid.joints.begin(), solid.joints.end(), [](const PlainJoint& one) {
      return starts_at_zero(one) && std::all_of(one.v.begin(), one.v.end(), [](double v) { return v == 0; });
    });
    if (!at_zero) lost_.add(starts, free);
    for (const PlainJoint& one : solid.joints) note_passive(one, false);
  }

  static bool starts_at_zero(const PlainJoint& one) {
    return one.kind == LinkJoint::ball ? one.displaced(one.q).R.isIdentity(1e-15) : one.q[0] == 0;
  }

  void note_passive(const PlainJoint& one, bool holds_damping) {
    if (one.stiffness > 0) lost_.add("springs of joints are not written", one.name);
    if (one.damping > 0 && !holds_damping) lost_.add("dampers of balls are not written", one.name);
    if (one.armature > 0) lost_.add("armatures are not written", one.name);
  }

  // Returns the link behind the joint: `link`, or a new one where it is empty.
  std::string behind(const std::string& link, const std::string& joint) {
    if (!link.empty()) return link;
    const std::string name = link_names_.make(joint + "_link");
    add_least_inertia(add_link(name));
    lost_.add("several coordinates of one solid have links of 1e-15 kg and 1e-15 kg m^2 between them", name);
    return name;
  }

  std::string add_scalar(const PlainJoint& one, const std::string& parent, const std::string& link) {
    const std::string name = joint_of_.at(one.name), child = behind(link, name);
    const bool slides = one.kind == LinkJoint::slide;
    const char* type = slides ? "prismatic" : one.range ? "revolute" : "continuous";
    XmlNode& joint = add_joint(name, type, parent, child, one.before);
    joint.add("axis").set("xyz", one.axis);
    if (slides || one.range) {
      const Range range = one.range.value_or(Range{-unbounded, unbounded});
      if (!one.range) lost_.add("slides without a range get one of 1e6 m, since URDF demands one", one.name);
      joint.add("limit")
          .set("lower", range.lower)
          .set("upper", range.upper)
          .set("effort", unbounded)
          .set("velocity", unbounded);
    }
    if (one.damping > 0) joint.add("dynamics").set("damping", one.damping);
    note_passive(one, true);
    if (!starts_at_zero(one) || one.v[0] != 0) lost_.add(starts, one.name);
    return child;
  }

  // R = R_x(a) R_y(b) R_z(c), about the ball's axes in its link
  std::string add_ball(const PlainJoint& ball, std::string parent, const std::string& link) {
    const std::string name = joint_of_.at(ball.name);
    for (int i = 0; i < 3; ++i) {
      const std::string hinge = joint_names_.make(fmt::format("{}.{}", name, "xyz"[i]));
      const std::string child = behind(i == 2 ? link : "", hinge);
      add_joint(hinge, "continuous", parent, child, i == 0 ? ball.before : Pose{})
          .add("axis")
          .set("xyz", Vector3d(ball.own_axes.col(i)));
      parent = child;
    }
    lost_.add(
        "balls are three hinges about their own x, y and z (NAME.x, NAME.y, NAME.z), which lose a "
        "direction where NAME.y is a right angle",
        ball.name);
    note_passive(ball, false);
    const bool turns = std::any_of(ball.v.begin(), ball.v.end(), [](double v) { return v != 0; });
    if (!starts_at_zero(ball) || turns) lost_.add(starts, ball.name);
    return parent;
  }

  static void add_least_inertia(XmlNode& link) {
    write_inertial(link, {least_link_inertia, Vector3d::Zero(), least_link_inertia * Matrix3d::Identity()});
  }

  // In principal axes, since MuJoCo loses digits of a full tensor: its search for the axes stops early. A
  // tensor that is diagonal to rounding keeps the link's axes.
  static void write_inertial(XmlNode& link, const Inertial& own) {
    Matrix3d R = Matrix3d::Identity(), I = own.tensor;
    const double outside = std::max({std::abs(I(0, 1)), std::abs(I(0, 2)), std::abs(I(1, 2))});
    if (outside > 1e-15 * I.diagonal().maxCoeff()) {
      const PrincipalAxes principal = own.principal();
      Vector3d moments = principal.moments;
      // flat bodies: rounding must not break the triangle inequality
      moments[2] = std::min(moments[2], moments[0] + moments[1]);
      R = principal.axes, I = moments.asDiagonal();
    }
    XmlNode& node = link.add("inertial");
    add_origin(node, {R, own.centre});
    node.add("mass").set("value", own.mass);
    node.add("inertia")
        .set("ixx", I(0, 0))
        .set("ixy", I(0, 1))
        .set("ixz", I(0, 2))
        .set("iyy", I(1, 1))
        .set("iyz", I(1, 2))
        .set("izz", I(2, 2));
  }

  void add_inertial(XmlNode& link, const Inertial& own, bool moves, const std::string& solid) {
    if (own.mass > 0) return write_inertial(link, own);
    if (!moves) return;
    add_least_inertia(link);
    lost_.add("moving solids without mass get 1e-15 kg and 1e-15 kg m^2, which simulators need", solid);
  }

  // ---- shapes ----

  XmlNode& add_geometry(XmlNode& link, const char* use, const Pose& X) {
    XmlNode& node = link.add(use);
    add_origin(node, X);
    return node.add("geometry");
  }

  void add_shape(XmlNode& link, const Shape& shape, const std::string& solid) {
    const Pose X{shape.orientation.toRotationMatrix(), shape.position};
    if (const auto* box = std::get_if<Box>(&shape.form))
      add_geometry(link, "visual", X).add("box").set("size", box->size);
    else if (const auto* sphere = std::get_if<Sphere>(&shape.form))
      add_geometry(link, "visual", X).add("sphere").set("radius", sphere->radius);
    else if (const auto* tube = std::get_if<Cylinder>(&shape.form))
      add_geometry(link, "visual", X).add("cylinder").set("radius", tube->radius).set("length", tube->length);
    else if (const auto* capsule = std::get_if<Capsule>(&shape.form))
      add_capsule(link, *capsule, X);
    else
      lost_.add("ellipsoids, cones and triangles are not drawn", solid);
  }

  // URDF has no capsule: a cylinder with a sphere at either end.
  void add_capsule(XmlNode& link, const Capsule& capsule, const Pose& X) {
    if (capsule.length > 0)
      add_geometry(link, "visual", X)
          .add("cylinder")
          .set("radius", capsule.radius)
          .set("length", capsule.length);
    for (const double side : {0.5, -0.5})
      add_geometry(link, "visual", X * Pose{Matrix3d::Identity(), {0, 0, side * capsule.length}})
          .add("sphere")
          .set("radius", capsule.radius);
  }

  void add_meshes() {
    for (const ModelMesh& mesh : extras_.meshes)
      if (const auto link = links_.find(mesh.solid); link != links_.end())
        add_geometry(*link->second, "visual", {Matrix3d::Identity(), mesh.position})
            .add("mesh")
            .set("filename", mesh.file)
            .set("scale", std::vector<double>(3, mesh.metres_per_unit));
  }

  void add_markers() {
    for (const Marker& marker : plain_.scene.markers) {
      const std::string link = renamed(link_names_, marker.name);
      add_joint(joint_names_.make(link + "_fixed"), "fixed", link_of_.at(marker.at.solid), link,
                {Matrix3d::Identity(), marker.at.point});
      add_link(link);
      lost_.add("markers are links without mass", marker.name);
    }
    for (const ModelFrame& frame : extras_.frames) {
      if (!link_of_.contains(frame.solid)) continue;
      const std::string link = renamed(link_names_, frame.name);
      add_joint(joint_names_.make(link + "_fixed"), "fixed", link_of_.at(frame.solid), link, frame.pose);
      add_link(link);
    }
  }

  // ---- constraints ----

  // A linear relation of two coordinates is a <mimic>, if the first has none yet.
  void add_constraint(const Constraint& constraint) {
    std::string on, of;
    double factor = 0, offset = 0;
    if (const auto* tie = std::get_if<CoordinateFunction>(&constraint.kind)) {
      const auto line = polynomial(tie->function, 1);
      if (line) on = tie->on.coordinate, of = tie->of.coordinate, offset = line->at(0), factor = line->at(1);
    } else if (const auto* gear = std::get_if<CoordinateCoupling>(&constraint.kind)) {
      const auto value = polynomial(gear->value, 0);
      if (value && gear->coordinates.size() == 2 && gear->ratios[0] != 0) {
        on = gear->coordinates[0].coordinate, of = gear->coordinates[1].coordinate;
        offset = value->at(0) / gear->ratios[0], factor = -gear->ratios[1] / gear->ratios[0];
      }
    }
    XmlNode* joint = on.empty() ? nullptr : scalar_joint(on);
    if (!joint || !scalar_joint(of) || !mimics_.insert(on).second) {
      lost_.add("constraints are not written", named_with_kind(constraint));
      return;
    }
    joint->add("mimic").set("joint", joint_of_.at(of)).set("multiplier", factor).set("offset", offset);
    lost_.add("couplings are <mimic>, which simulators may ignore", constraint.name);
  }

  // The element of a hinge or slide; null: there is none.
  XmlNode* scalar_joint(const std::string& coordinate) {
    const auto name = joint_of_.find(coordinate);
    if (name == joint_of_.end()) return nullptr;
    for (XmlNode& node : root_.children) {
      if (node.name != "joint" || node.attributes[0].second != name->second) continue;
      const std::string& type = node.attributes[1].second;
      return type == "continuous" || type == "revolute" || type == "prismatic" ? &node : nullptr;
    }
    return nullptr;
  }

  void list_settings() {
    if (plain_.scene.gravity != Vector3d(0, 0, -9.81))
      lost_.add("gravity is not written", fmt::format("{} {} {} m/s^2", plain_.scene.gravity.x(),
                                                      plain_.scene.gravity.y(), plain_.scene.gravity.z()));
    list_run_settings(plain_.scene.simulation, lost_);
  }

  static constexpr const char* starts = "starts other than zero, at rest, are not written";

  const PlainScene& plain_;
  const ModelExtras& extras_;
  Omissions& lost_;
  XmlNode root_{.name = "robot"};
  UniqueNames link_names_, joint_names_;
  std::map<std::string, std::string> link_of_, joint_of_;  // by solid, by coordinate
  std::map<std::string, XmlNode*> links_;
  std::set<std::string> mimics_;
};

}  // namespace

Result<WrittenModel> write_urdf(const Scene& scene, const ModelExtras& extras) {
  Omissions lost;
  const auto plain = plain_scene(scene, 1, lost);
  if (!plain) return tl::unexpected(plain.error());
  std::string text = UrdfWriter(**plain, extras, lost).write();
  return WrittenModel{std::move(text), lost.sentences()};
}

}  // namespace borelli
