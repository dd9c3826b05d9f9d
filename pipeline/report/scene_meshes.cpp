#include "pipeline/report/scene_meshes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "dynamics/numbers/rotation_between.hpp"
#include "pipeline/export/glb.hpp"
#include "pipeline/on_demand/vtk.hpp"
#include "pipeline/report/report.hpp"
#include "process/on_demand.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

using AddForm = decltype(VtkFunctions::add_form);

void rod(AddForm add, Mesh& mesh, const Vector3d& from, const Vector3d& to, double radius) {
  const Vector3d d = to - from;
  if (d.norm() < 2 * radius) return;
  const Pose X{rotation_between(Vector3d::UnitZ(), d), (from + to) / 2};
  add(mesh, X, Cylinder{radius, d.norm()});
}

/// A plane that a constraint places in a solid or the world.
struct HeldPlane {
  std::string name;
  SolidPoint point;
  Vector3d normal = Vector3d::UnitZ();
};

/// Points where constraints and efforts attach to solids, by solid; and the planes of constraints.
struct Holds {
  std::map<std::string, std::vector<Vector3d>> points;
  std::vector<HeldPlane> planes;
  std::string name;      ///< of the visited constraint or effort
  bool contact = false;  ///< it is a contact, whose plane is drawn

  void operator()(std::string_view field, const SolidPoint& at) {
    if (field == "plane" && contact)
      planes.push_back({name, at, Vector3d::UnitZ()});
    else
      points[at.solid].push_back(at.point);
  }
  void operator()(std::string_view field, const Vector3d& value) {
    if (field == "normal" && !planes.empty() && planes.back().name == name)
      planes.back().normal = value.normalized();
  }
  template <class T>
  void operator()(std::string_view, const T&) {}
};

Holds holds_of(const Scene& scene) {
  Holds holds;
  const auto visit = [&](const auto& things) {
    for (const auto& thing : things) {
      holds.name = thing.name;
      std::visit(
          [&](const auto& kind) {
            holds.contact = Unilateral<std::decay_t<decltype(kind)>>;
            kind.fields(kind, holds);
          },
          thing.kind);
    }
  };
  visit(scene.constraints);
  visit(scene.efforts);
  for (const Solid& solid : scene.solids) {
    Pose X;
    for (const Switch& one : solid.switches) {
      const auto* fixed = std::get_if<Fixed>(&one.kind);
      if (!fixed) break;
      X = X * fixed->X_AB;
    }
    holds.points[solid.parent].push_back(X.p);
  }
  return holds;
}

/// Edges of the uniform box with this mass and these principal moments.
Vector3d box_of(double mass, const Vector3d& moments) {
  const double sum = moments.sum();
  return (6 / mass * (Vector3d::Constant(sum) - 2 * moments)).cwiseMax(0).cwiseSqrt();
}

/// Substitute for a solid without a shape: rods to its attachment points, or its inertia box if all of them
/// are at the origin. `thickness` suits the scene.
Result<void> stand_in(AddForm add, Mesh& mesh, const Solid& solid, const std::vector<Vector3d>& points,
                      double thickness) {
  for (const Vector3d& point : points) rod(add, mesh, Vector3d::Zero(), point, thickness / 2);
  if (!mesh.triangles.empty()) return {};
  const auto elements = inertials_of(solid);
  if (!elements) return tl::unexpected(elements.error());
  Inertial whole;
  for (const Inertial& element : *elements) whole += element;
  if (!(whole.mass > 0)) return {};
  rod(add, mesh, Vector3d::Zero(), whole.centre, thickness / 2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(whole.tensor);
  Eigen::Matrix3d R = principal.eigenvectors();
  if (R.determinant() < 0) R.col(0) = -R.col(0);
  const Pose X{R, whole.centre};
  const Vector3d edges = box_of(whole.mass, principal.eigenvalues());
  if (edges.maxCoeff() < thickness)
    add(mesh, X, Sphere{2 * thickness});
  else
    add(mesh, X, Box{edges.cwiseMax(thickness)});
  return {};
}

/// Size of the scene's solids.
double extent(const Scene& scene, const Holds& holds) {
  double largest = 0;
  const auto reach = [&](const Vector3d& p) { largest = std::max(largest, p.norm()); };
  for (const auto& [solid, points] : holds.points)
    if (solid != world_name) std::ranges::for_each(points, reach);
  for (const Solid& solid : scene.solids) {
    if (const auto elements = inertials_of(solid))
      for (const Inertial& element : *elements) {
        reach(element.centre);
        if (element.mass > 0)
          largest = std::max(largest, 3 * std::sqrt(element.tensor.trace() / element.mass) / 2);
      }
  }
  return largest > 0 ? largest : 1;
}

void plate(AddForm add, Mesh& mesh, const HeldPlane& plane, double size) {
  const double thickness = size / 200;
  const Pose X{rotation_between(Vector3d::UnitZ(), plane.normal),
               plane.point.point - thickness / 2 * plane.normal};
  add(mesh, X, Box{{size, size, thickness}});
}

}  // namespace

Result<std::vector<Mesh>> scene_meshes(const Scene& scene) {
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  const AddForm add = (*vtk)->add_form;
  const Holds holds = holds_of(scene);
  const double size = extent(scene, holds);
  std::vector<Mesh> meshes;
  for (const Solid& solid : scene.solids) {
    Mesh mesh{solid.name, {}, {}};
    for (const ShapeElement& element : solid.shapes) {
      const Shape& shape = element.shape;
      add(mesh, {shape.orientation.toRotationMatrix(), shape.position}, shape.form);
    }
    if (solid.shapes.empty()) {
      const auto points = holds.points.find(solid.name);
      if (auto drawn =
              stand_in(add, mesh, solid,
                       points == holds.points.end() ? std::vector<Vector3d>{} : points->second, 0.03 * size);
          !drawn)
        return tl::unexpected(drawn.error());
    }
    for (const HeldPlane& plane : holds.planes)
      if (plane.point.solid == solid.name) plate(add, mesh, plane, 2 * size);
    if (!mesh.triangles.empty()) meshes.push_back(std::move(mesh));
  }
  for (const HeldPlane& plane : holds.planes) {
    if (plane.point.solid != world_name) continue;
    Mesh mesh{"world: " + plane.name, {}, {}};
    plate(add, mesh, plane, 4 * size);
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

Result<std::string> scene_glb(const Scene& scene, const Trajectory& trajectory) {
  const auto meshes = scene_meshes(scene);
  if (!meshes) return tl::unexpected(meshes.error());
  ScanPoses own_frames;
  GlbSettings settings;
  settings.title = scene.name;
  // fast motions are played slowly
  if (const double span = trajectory.times.empty() ? 0 : trajectory.times.back() - trajectory.times.front();
      span > 0)
    settings.samples_per_second = std::max(settings.samples_per_second, 300 / span);
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    own_frames.emplace(scene.solids[i].name, Pose{});
    settings.colours.emplace(scene.solids[i].name, other_colour(i + 1));
  }
  return glb(*meshes, own_frames, trajectory, settings);
}

Result<std::string> scene_page(const Scene& scene, const Trajectory& trajectory,
                               const std::vector<std::string>& warnings) {
  const auto body = scene_glb(scene, trajectory);
  if (!body) return body;
  ReportInputs page;
  page.subject = scene.name;
  page.trajectory = &trajectory;
  page.glb = *body;
  if (!warnings.empty()) page.run = {{"warnings", warnings}};
  return report_page(page);
}

}  // namespace borelli
