// Writes scenes as models of OpenSim, in the layout that OpenSim 4 writes. The reader is osim.hpp.
//
// Format: opensim-org/opensim-core, OpenSim/Simulation/Model and OpenSim/Simulation/SimbodyEngine; names and
// nesting of elements as in opensim-org/opensim-models.

#include <fmt/core.h>

#include <numbers>
#include <set>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/osim_write_force.hpp"
#include "dynamics/formats/osim_write_function.hpp"
#include "dynamics/formats/osim_write_geometry.hpp"
#include "dynamics/formats/osim_write_joint.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {
namespace {

constexpr double usual_slide = 5;  // m, of coordinates without a range: OpenSim's sliders need one

class OsimWriter {
 public:
  OsimWriter(const Scene& scene, const ModelExtras& extras) : scene_(scene), extras_(extras), names_(scene) {}

  Result<WrittenModel> write() {
    XmlNode root{"OpenSimDocument"};
    root.set("Version", "40000");
    XmlNode& model = root.add("Model").set("name", scene_.name.empty() ? "model" : scene_.name);
    add_head(model);
    XmlNode& bodies = model.add("BodySet").set("name", "bodyset").add("objects");
    XmlNode& joints = model.add("JointSet").set("name", "jointset").add("objects");
    XmlNode& forces = model.add("ForceSet").set("name", "forceset").add("objects");
    XmlNode& markers = model.add("MarkerSet").set("name", "markerset").add("objects");
    XmlNode& shapes = model.add("ContactGeometrySet").set("name", "contactgeometryset").add("objects");
    XmlNode& constraints = model.add("ConstraintSet").set("name", "constraintset").add("objects");
    for (const Solid& solid : scene_.solids)
      if (auto done = add_solid(solid, bodies, joints, constraints); !done)
        return tl::unexpected(done.error());
    for (const Marker& marker : scene_.markers) add_marker(marker, markers);
    write_osim_forces(scene_, names_, forces, lost_);
    write_osim_constraints(scene_, names_, constraints, lost_);
    write_osim_contact_shapes(scene_, names_, shapes);
    names_.report_renamed(lost_);
    list_run_settings(scene_.simulation, lost_);
    model.children.remove_if([](const XmlNode& set) {  // without objects
      return set.name.ends_with("Set") && set.children.front().children.empty();
    });
    XmlNode lost{"Model"};
    for (const std::string& sentence : lost_.sentences()) lost.comment("Lost or changed: " + sentence);
    model.children.splice(model.children.begin(), lost.children);
    return WrittenModel{xml_text(root), lost_.sentences()};
  }

 private:
  void add_head(XmlNode& model) {
    for (const std::string& line : extras_.comments) model.comment(line);
    if (names_.turns_world())
      model.comment(
          "y is up: the x, y and z axes of the scene are x, -z and y here; coordinates are the same");
    XmlNode& ground = model.add("Ground").set("name", "ground");
    write_osim_geometry(world_name, nullptr, extras_, names_, ground, lost_);
    model.add("gravity", osim_vector_text(names_.in_ground(scene_.gravity)));
    model.add("credits", scene_.description);
    model.add("length_units", "meters");
    model.add("force_units", "N");
  }

  Result<void> add_solid(const Solid& solid, XmlNode& bodies, XmlNode& joints, XmlNode& constraints) {
    const auto chain = write_osim_chain(scene_, solid, names_, lost_);
    if (!chain) return tl::unexpected(chain.error());
    const auto inertials = inertials_of(solid);
    if (!inertials) return tl::unexpected(inertials.error());
    Inertial sum;
    for (const Inertial& one : *inertials) sum += one;
    std::string parent = names_.path(solid.parent);
    for (std::size_t i = 0; i < chain->joints.size(); ++i) {
      const bool last = i + 1 == chain->joints.size();
      const std::string name = last ? names_.body(solid.name) : names_.new_body(solid.name + "_before");
      WrittenJoint joint = chain->joints[i];
      if (i == 0) joint.X_PF = names_.in_frame(solid.parent, joint.X_PF);
      add_joint(joint, i == 0 ? solid.parent : "", parent, name, joints);
      add_body(name, last ? sum : Inertial{}, last ? &solid : nullptr, bodies);
      parent = "/bodyset/" + name;
    }
    for (const WrittenCoupling& tie : chain->couplings)
      write_osim_coupler(constraints, OsimNames::make(tie.on + "_follows", taken_ties_), tie.on, tie.of,
                         tie.by);
    return {};
  }

  void add_body(const std::string& name, const Inertial& own, const Solid* solid, XmlNode& bodies) {
    XmlNode& body = bodies.add("Body").set("name", name);
    if (solid) write_osim_geometry(solid->name, solid, extras_, names_, body, lost_);
    body.add("mass", exact_text(own.mass));
    body.add("mass_center", osim_vector_text(own.centre));
    const Eigen::Matrix3d& I = own.tensor;
    body.add("inertia", exact_text(std::vector{I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}));
  }

  // A coordinate of its own gives the joint its name, as in OpenSim's models: hip_left, ground_pelvis.
  std::string joint_name(const WrittenJoint& joint, const std::string& parent_solid,
                         const std::string& body) {
    std::string wanted = parent_solid == world_name ? "ground_" + body : body + "_joint";
    if (parent_solid != world_name && joint.coordinates.size() == 1) wanted = joint.coordinates[0].name;
    if (parent_solid != world_name && joint.coordinates.size() == 3 && joint.translations.empty())
      if (const std::string& angle = joint.coordinates[0].name; angle.ends_with("_x"))  // of a ball
        wanted = angle.substr(0, angle.size() - 2);
    return OsimNames::make(wanted, taken_joints_);
  }

  void add_joint(const WrittenJoint& joint, const std::string& parent_solid, const std::string& parent,
                 const std::string& body, XmlNode& joints) {
    const char* kind = kind_of(joint);
    XmlNode& node = joints.add(kind).set("name", joint_name(joint, parent_solid, body));
    const std::string from = parent.substr(parent.find_last_of('/') + 1) + "_offset", to = body + "_offset";
    node.add("socket_parent_frame", from);
    node.add("socket_child_frame", to == from ? to + "_2" : to);
    XmlNode& coordinates = node.add("coordinates");
    for (const WrittenCoordinate& one : joint.coordinates) add_coordinate(one, coordinates);
    XmlNode& frames = node.add("frames");
    write_osim_frame(frames, from, parent, joint.X_PF);
    write_osim_frame(frames, to == from ? to + "_2" : to, "/bodyset/" + body, joint.X_MB.inverse());
    if (std::string_view(kind) == "CustomJoint") add_transform(joint, node);
  }

  // CustomJoint holds all; Moco refuses BallJoint and FreeJoint, whose speeds are no rates.
  static const char* kind_of(const WrittenJoint& joint) {
    if (joint.translations.empty() && joint.rotations.empty()) return "WeldJoint";
    const auto alone = [](const std::vector<WrittenAxis>& axes, const Eigen::Vector3d& axis) {
      if (axes.size() != 1 || axes[0].part.axis != axis) return false;
      const auto* by = std::get_if<Polynomial>(&axes[0].part.by);
      return by && by->coefficients == std::vector<double>{0, 1};
    };
    if (joint.translations.empty() && alone(joint.rotations, Eigen::Vector3d::UnitZ())) return "PinJoint";
    if (joint.rotations.empty() && alone(joint.translations, Eigen::Vector3d::UnitX())) return "SliderJoint";
    return "CustomJoint";
  }

  static void add_coordinate(const WrittenCoordinate& one, XmlNode& coordinates) {
    XmlNode& node = coordinates.add("Coordinate").set("name", one.name);
    const double usual = one.turns ? std::numbers::pi : usual_slide;
    const Range range =
        one.range.value_or(Range{std::min(-usual, one.start - usual), std::max(usual, one.start + usual)});
    node.add("default_value", exact_text(one.start));
    node.add("default_speed_value", exact_text(one.speed));
    node.add("range", exact_text(std::vector{range.lower, range.upper}));
    node.add("clamped", one.clamped ? "true" : "false");
    node.add("locked", one.locked ? "true" : "false");
    XmlNode& function = node.add("prescribed_function");
    if (one.prescribed) write_osim_function(function, *one.prescribed, "function");
    node.add("prescribed", one.prescribed ? "true" : "false");
  }

  static void add_transform(const WrittenJoint& joint, XmlNode& node) {
    XmlNode& transform = node.add("SpatialTransform");
    add_axes("rotation", joint.rotations, joint, transform);
    add_axes("translation", joint.translations, joint, transform);
  }

  // OpenSim wants three axes of which no two are parallel, also of those that do not move.
  static void add_axes(const std::string& name, const std::vector<WrittenAxis>& used,
                       const WrittenJoint& joint, XmlNode& transform) {
    std::vector<Eigen::Vector3d> axes;
    for (const WrittenAxis& one : used) axes.push_back(one.part.axis);
    if (axes.empty()) axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
    if (axes.size() == 1) axes.push_back(axes[0].unitOrthogonal());
    if (axes.size() == 2) axes.push_back(axes[0].cross(axes[1]).normalized());
    for (std::size_t i = 0; i < 3; ++i) {
      XmlNode& axis = transform.add("TransformAxis").set("name", fmt::format("{}{}", name, i + 1));
      axis.add("coordinates", i < used.size() ? joint.coordinates[used[i].coordinate].name : "");
      axis.add("axis", osim_vector_text(axes[i]));
      write_osim_function(axis, i < used.size() ? used[i].part.by : constant(0), "function");
    }
  }

  void add_marker(const Marker& marker, XmlNode& markers) {
    XmlNode& node = markers.add("Marker").set("name", OsimNames::make(marker.name, taken_markers_));
    if (const std::string& written = node.attributes[0].second; written != marker.name)
      lost_.add("names of markers are others", fmt::format("'{}' as '{}'", marker.name, written));
    node.add("socket_parent_frame", names_.path(marker.at.solid));
    node.add("location", osim_vector_text(names_.point(marker.at)));
    node.add("fixed", "false");
  }

  const Scene& scene_;
  const ModelExtras& extras_;
  OsimNames names_;
  Omissions lost_;
  std::set<std::string> taken_joints_, taken_ties_, taken_markers_;
};

}  // namespace

Result<WrittenModel> write_osim(const Scene& scene, const ModelExtras& extras) {
  if (const auto system = compile(scene); !system) return tl::unexpected(system.error());
  return OsimWriter(scene, extras).write();
}

}  // namespace borelli
