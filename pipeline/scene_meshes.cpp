#include "pipeline/scene_meshes.hpp"

#include <vtkCapsuleSource.h>
#include <vtkConeSource.h>
#include <vtkCubeSource.h>
#include <vtkCylinderSource.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSphereSource.h>
#include <vtkTriangleFilter.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/glb.hpp"
#include "pipeline/report.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr int sides = 32;

/// Adds a VTK source's triangles, moved by X and first scaled along its own axes.
void append(Mesh& mesh, vtkPolyDataAlgorithm* source, const Pose& X,
            const Vector3d& scale = Vector3d::Ones()) {
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputConnection(source->GetOutputPort());
  triangles->Update();
  vtkPolyData* data = triangles->GetOutput();
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    Vector3d p;
    data->GetPoint(i, p.data());
    mesh.points.push_back((X * p.cwiseProduct(scale).eval()).cast<float>());
  }
  vtkNew<vtkIdList> corners;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    data->GetCellPoints(c, corners);
    if (corners->GetNumberOfIds() != 3) continue;
    std::array<std::uint32_t, 3> triangle{};
    for (vtkIdType i = 0; i < 3; ++i)
      triangle[static_cast<std::size_t>(i)] = first + static_cast<std::uint32_t>(corners->GetId(i));
    mesh.triangles.push_back(triangle);
  }
}

/// VTK's cylinders, capsules and cones lie along y or x, ours along z.
Pose along_z(const Pose& X, const Vector3d& their_axis) {
  return X * Pose{Eigen::Quaterniond::FromTwoVectors(their_axis, Vector3d::UnitZ()).toRotationMatrix(),
                  Vector3d::Zero()};
}

struct Drawing {
  Mesh& mesh;
  Pose X;  ///< of the form in its solid

  void operator()(const Box& box) const {
    vtkNew<vtkCubeSource> cube;
    append(mesh, cube, X, box.size);
  }
  void operator()(const Sphere& sphere) const { (*this)(Ellipsoid{Vector3d::Constant(sphere.radius)}); }
  void operator()(const Ellipsoid& ellipsoid) const {
    vtkNew<vtkSphereSource> ball;
    ball->SetRadius(1);
    ball->SetThetaResolution(sides);
    ball->SetPhiResolution(sides / 2);
    append(mesh, ball, X, ellipsoid.radii);
  }
  void operator()(const Cylinder& cylinder) const {
    vtkNew<vtkCylinderSource> barrel;
    barrel->SetRadius(cylinder.radius);
    barrel->SetHeight(cylinder.length);
    barrel->SetResolution(sides);
    append(mesh, barrel, along_z(X, Vector3d::UnitY()));
  }
  void operator()(const Capsule& capsule) const {
    vtkNew<vtkCapsuleSource> pill;
    pill->SetRadius(capsule.radius);
    pill->SetCylinderLength(capsule.length);
    pill->SetThetaResolution(sides);
    pill->SetPhiResolution(sides / 2);
    append(mesh, pill, along_z(X, Vector3d::UnitY()));
  }
  void operator()(const Cone& cone) const {
    vtkNew<vtkConeSource> hat;
    hat->SetRadius(cone.radius);
    hat->SetHeight(cone.length);
    hat->SetResolution(sides);
    hat->SetCenter(cone.length / 2, 0, 0);
    append(mesh, hat, along_z(X, Vector3d::UnitX()));
  }
  void operator()(const ClosedMesh& closed) const {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (const Vector3d& p : closed.vertices) mesh.points.push_back((X * p).cast<float>());
    for (const auto& t : closed.triangles)
      mesh.triangles.push_back({first + static_cast<std::uint32_t>(t[0]),
                                first + static_cast<std::uint32_t>(t[1]),
                                first + static_cast<std::uint32_t>(t[2])});
  }
};

void rod(Mesh& mesh, const Vector3d& from, const Vector3d& to, double radius) {
  const Vector3d d = to - from;
  if (d.norm() < 2 * radius) return;
  const Pose X{Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), d).toRotationMatrix(), (from + to) / 2};
  Drawing{mesh, X}(Cylinder{radius, d.norm()});
}

/// A plane that something holds against a solid or the world.
struct HeldPlane {
  std::string name;
  SolidPoint point;
  Vector3d normal = Vector3d::UnitZ();
};

/// Where constraints and efforts take hold of solids, by solid; and the planes of constraints.
struct Holds {
  std::map<std::string, std::vector<Vector3d>> points;
  std::vector<HeldPlane> planes;
  std::string name;      ///< of what is visited
  bool contact = false;  ///< it may touch its plane, which is then seen

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

/// The edges of the box of even density with this mass and these principal moments.
Vector3d box_of(double mass, const Vector3d& moments) {
  const double sum = moments.sum();
  return (6 / mass * (Vector3d::Constant(sum) - 2 * moments)).cwiseMax(0).cwiseSqrt();
}

/// A solid without a shape: what takes hold of it, or its inertia where nothing does but at its origin, drawn
/// with a thickness that fits the scene.
Result<void> stand_in(Mesh& mesh, const Solid& solid, const std::vector<Vector3d>& held, double thickness) {
  for (const Vector3d& point : held) rod(mesh, Vector3d::Zero(), point, thickness / 2);
  if (!mesh.triangles.empty()) return {};
  const auto elements = inertials_of(solid);
  if (!elements) return tl::unexpected(elements.error());
  Inertial whole;
  for (const Inertial& element : *elements) whole += element;
  if (!(whole.mass > 0)) return {};
  rod(mesh, Vector3d::Zero(), whole.centre, thickness / 2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(whole.tensor);
  Eigen::Matrix3d R = principal.eigenvectors();
  if (R.determinant() < 0) R.col(0) = -R.col(0);
  const Pose X{R, whole.centre};
  const Vector3d edges = box_of(whole.mass, principal.eigenvalues());
  if (edges.maxCoeff() < thickness)
    Drawing{mesh, X}(Sphere{2 * thickness});
  else
    Drawing{mesh, X}(Box{edges.cwiseMax(thickness)});
  return {};
}

/// How large the scene's solids are.
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

void plate(Mesh& mesh, const HeldPlane& plane, double size) {
  const double thickness = size / 200;
  const Pose X{Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), plane.normal).toRotationMatrix(),
               plane.point.point - thickness / 2 * plane.normal};
  Drawing{mesh, X}(Box{{size, size, thickness}});
}

}  // namespace

Result<std::vector<Mesh>> scene_meshes(const Scene& scene) {
  const Holds holds = holds_of(scene);
  const double size = extent(scene, holds);
  std::vector<Mesh> meshes;
  for (const Solid& solid : scene.solids) {
    Mesh mesh{solid.name, {}, {}};
    for (const ShapeElement& element : solid.shapes) {
      const Shape& shape = element.shape;
      std::visit(Drawing{mesh, {shape.orientation.toRotationMatrix(), shape.position}}, shape.form);
    }
    if (solid.shapes.empty()) {
      const auto held = holds.points.find(solid.name);
      if (auto drawn = stand_in(
              mesh, solid, held == holds.points.end() ? std::vector<Vector3d>{} : held->second, 0.03 * size);
          !drawn)
        return tl::unexpected(drawn.error());
    }
    for (const HeldPlane& plane : holds.planes)
      if (plane.point.solid == solid.name) plate(mesh, plane, 2 * size);
    if (!mesh.triangles.empty()) meshes.push_back(std::move(mesh));
  }
  for (const HeldPlane& plane : holds.planes) {
    if (plane.point.solid != world_name) continue;
    Mesh mesh{"world: " + plane.name, {}, {}};
    plate(mesh, plane, 4 * size);
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
  // fast motions are looked at slowly
  if (const double span = trajectory.times.empty() ? 0 : trajectory.times.back() - trajectory.times.front();
      span > 0)
    settings.samples_per_second = std::max(settings.samples_per_second, 300 / span);
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    own_frames.emplace(scene.solids[i].name, Pose{});
    settings.colours.emplace(scene.solids[i].name, other_colour(i + 1));
  }
  return glb(*meshes, own_frames, trajectory, settings);
}

Result<std::string> scene_page(const Scene& scene, const Trajectory& trajectory) {
  const auto body = scene_glb(scene, trajectory);
  if (!body) return body;
  ReportInputs page;
  page.subject = scene.name;
  page.trajectory = &trajectory;
  page.glb = *body;
  return report_page(page);
}

}  // namespace borelli
