// Triangle meshes of boxes, balls, cylinders, capsules and cones.
#include <vtkCapsuleSource.h>
#include <vtkConeSource.h>
#include <vtkCubeSource.h>
#include <vtkCylinderSource.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSphereSource.h>
#include <vtkTriangleFilter.h>

#include "pipeline/on_demand/vtk/functions.hpp"

namespace borelli::by_vtk {
namespace {

using Eigen::Vector3d;

constexpr int sides = 32;

/// Adds a VTK source's triangles, first scaled along its own axes, then moved by X.
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

/// VTK's cylinders, capsules and cones lie along y or x; ours lie along z.
Pose along_z(const Pose& X, const Vector3d& their_axis) {
  return X * Pose{Eigen::Quaterniond::FromTwoVectors(their_axis, Vector3d::UnitZ()).toRotationMatrix(),
                  Vector3d::Zero()};
}

struct Drawing {
  Mesh& mesh;
  Pose X;  ///< of the shape in its solid

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

}  // namespace

void add_form(Mesh& mesh, const Pose& X, const Form& form) { std::visit(Drawing{mesh, X}, form); }

}  // namespace borelli::by_vtk
