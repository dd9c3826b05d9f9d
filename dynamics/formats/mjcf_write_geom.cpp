// Shapes and meshes of scenes as MJCF's geoms.
#include <cmath>

#include "dynamics/formats/mjcf_draft.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

void add_mesh(MjcfDraft& draft, const PlainSolid& solid, const ClosedMesh& mesh, const Pose& X) {
  std::vector<double> vertices, faces;
  for (const Vector3d& p : mesh.vertices) vertices.insert(vertices.end(), p.begin(), p.end());
  for (const auto& t : mesh.triangles) faces.insert(faces.end(), t.begin(), t.end());
  const std::string name = draft.meshes.make(solid.source->name);
  draft.asset.add("mesh").set("name", name).set("vertex", vertices).set("face", faces);
  add_geom(draft, solid.source->name, {"mesh", X, {}}).set("mesh", name);
}

}  // namespace

// (MuJoCo takes half lengths and half edges.)
MjcfForm mjcf_form(const Form& form) {
  if (const auto* f = std::get_if<Sphere>(&form)) return {"sphere", {}, {f->radius}};
  if (const auto* f = std::get_if<Capsule>(&form)) return {"capsule", {}, {f->radius, f->length / 2}};
  if (const auto* f = std::get_if<Cylinder>(&form)) return {"cylinder", {}, {f->radius, f->length / 2}};
  if (const auto* f = std::get_if<Ellipsoid>(&form))
    return {"ellipsoid", {}, {f->radii.x(), f->radii.y(), f->radii.z()}};
  if (const auto* f = std::get_if<Box>(&form))
    return {"box", {}, {f->size.x() / 2, f->size.y() / 2, f->size.z() / 2}};
  return {};
}

bool MjcfForm::looks_like(const MjcfForm& other) const {
  constexpr double rounding = 1e-12;
  if (std::string_view(type) != other.type || size.size() != other.size.size()) return false;
  for (std::size_t i = 0; i < size.size(); ++i)
    if (std::abs(size[i] - other.size[i]) > rounding) return false;
  if ((X.p - other.X.p).norm() > rounding) return false;
  if (std::string_view(type) == "sphere") return true;
  if (std::string_view(type) == "capsule" || std::string_view(type) == "plane")
    return (X.R.col(2) - other.X.R.col(2)).norm() < rounding;
  return (X.R - other.X.R).norm() < rounding;
}

XmlNode& add_geom(MjcfDraft& draft, const std::string& solid, const MjcfForm& form) {
  XmlNode& body = *draft.bodies.at(solid);
  XmlNode& node = body.add("geom");
  node.set("type", form.type);
  set_place(node, form.X);
  if (!form.size.empty()) node.set("size", form.size);
  node.set("contype", "0").set("conaffinity", "0");
  draft.drawn[&body].push_back({form, &node, ""});
  return node;
}

void add_mjcf_shapes(MjcfDraft& draft, const std::vector<ModelMesh>& meshes) {
  for (const PlainSolid& solid : draft.plain.solids)
    for (const ShapeElement& element : solid.source->shapes) {
      const Shape& shape = element.shape;
      MjcfForm form = mjcf_form(shape.form);
      form.X = {shape.orientation.toRotationMatrix(), shape.position};
      if (*form.type)
        add_geom(draft, solid.source->name, form);
      else if (const auto* mesh = std::get_if<ClosedMesh>(&shape.form))
        add_mesh(draft, solid, *mesh, form.X);
      else
        draft.lost.add("cones are not drawn", solid.source->name);
    }
  for (const ModelMesh& mesh : meshes) {
    if (!draft.bodies.contains(mesh.solid)) continue;
    const std::string name = draft.meshes.make(mesh.solid);
    draft.asset.add("mesh")
        .set("name", name)
        .set("file", mesh.file)
        .set("scale", std::vector<double>(3, mesh.metres_per_unit));
    add_geom(draft, mesh.solid, {"mesh", {Eigen::Matrix3d::Identity(), mesh.position}, {}}).set("mesh", name);
  }
}

}  // namespace borelli
