#include "dynamics/formats/osim_write_geometry.hpp"

#include <fmt/core.h>

#include <numbers>

#include "dynamics/formats/osim_write_force.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

class OsimGeometryWriter {
 public:
  OsimGeometryWriter(std::string name, XmlNode& body) : name_(std::move(name)), body_(body) {}

  void mesh(const ModelMesh& mesh, const Pose& X) {
    XmlNode& node = geometry("Mesh", X);
    node.children.back().content = osim_vector_text(Vector3d::Constant(mesh.metres_per_unit));
    node.add("mesh_file", mesh.file);
  }

  void frame(const std::string& name, const Pose& X) { write_osim_frame(components(), name, "..", X); }

  /// False: OpenSim needs a file for it.
  bool shape(const Form& form, const Pose& X) {
    if (std::holds_alternative<ClosedMesh>(form)) return false;
    std::visit([&](const auto& one) { add(one, X); }, form);
    return true;
  }

 private:
  XmlNode& components() {
    if (!components_) components_ = &body_.add("components");
    return *components_;
  }

  // Geometry stands in the frame that holds it.
  XmlNode& geometry(const char* kind, const Pose& X) {
    const std::string name = fmt::format("{}_geom_{}", name_, ++count_);
    XmlNode* holder = &body_;
    const bool away = !X.R.isIdentity(0) || !X.p.isZero(0);
    if (away) {
      holder = &write_osim_frame(components(), name + "_frame", "..", X);
    }
    if (away || !attached_) {
      XmlNode& list = holder->add("attached_geometry");
      if (!away) attached_ = &list;
      holder = &list;
    } else {
      holder = attached_;
    }
    XmlNode& node = holder->add(kind).set("name", name);
    node.add("socket_frame", "..");
    node.add("scale_factors", "1 1 1");
    return node;
  }

  void add(const Box& box, const Pose& X) {
    geometry("Brick", X).add("half_lengths", osim_vector_text(box.size / 2));
  }
  void add(const Sphere& ball, const Pose& X) {
    geometry("Sphere", X).add("radius", exact_text(ball.radius));
  }
  void add(const Ellipsoid& egg, const Pose& X) {
    geometry("Ellipsoid", X).add("radii", osim_vector_text(egg.radii));
  }
  // OpenSim's cylinder lies along y.
  void add(const Cylinder& rod, const Pose& X) {
    const Pose turned{rotation_about(Vector3d::UnitX(), std::numbers::pi / 2), Vector3d::Zero()};
    XmlNode& node = geometry("Cylinder", X * turned);
    node.add("radius", exact_text(rod.radius));
    node.add("half_height", exact_text(rod.length / 2));
  }
  void add(const Cone& cone, const Pose& X) {
    XmlNode& node = geometry("Cone", X);
    node.add("origin", "0 0 0");
    node.add("direction", "0 0 1");
    node.add("base_radius", exact_text(cone.radius));
    node.add("height", exact_text(cone.length));
  }
  void add(const Capsule& capsule, const Pose& X) {
    add(Cylinder{capsule.radius, capsule.length}, X);
    for (const double end : {-0.5, 0.5})
      add(Sphere{capsule.radius}, X * Pose{Eigen::Matrix3d::Identity(), {0, 0, end * capsule.length}});
  }
  void add(const ClosedMesh&, const Pose&) {}

  std::string name_;
  XmlNode& body_;
  XmlNode *components_ = nullptr, *attached_ = nullptr;
  int count_ = 0;
};

}  // namespace

void write_osim_geometry(const std::string& name, const Solid* solid, const ModelExtras& extras,
                         const OsimNames& names, XmlNode& body, Omissions& lost) {
  OsimGeometryWriter writer(solid ? names.body(name) : "ground", body);
  for (const ModelMesh& mesh : extras.meshes)
    if (mesh.solid == name)
      writer.mesh(mesh, names.in_frame(name, {Eigen::Matrix3d::Identity(), mesh.position}));
  for (const ModelFrame& frame : extras.frames)
    if (frame.solid == name) writer.frame(frame.name, names.in_frame(name, frame.pose));
  if (!solid) return;
  bool all = true;
  for (const ShapeElement& element : solid->shapes) {
    const Shape& shape = element.shape;
    all = writer.shape(shape.form, {shape.orientation.toRotationMatrix(), shape.position}) && all;
  }
  if (!all) lost.add("shapes made of triangles are not drawn; OpenSim draws those of files", name);
}

}  // namespace borelli
