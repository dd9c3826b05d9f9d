#include "dynamics/formats/mjcf_shell.hpp"

#include <cmath>
#include <numbers>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

struct SurfaceMoments {
  double area = 0;
  Vector3d first = Vector3d::Zero();   // integral of x
  Matrix3d second = Matrix3d::Zero();  // integral of x x^T
};

SurfaceMoments of(double area, const Vector3d& squares, double height = 0) {
  return {area, {0, 0, height * area}, squares.asDiagonal()};
}

SurfaceMoments surface(const Box& box) {
  const Vector3d h = box.size / 2;
  Vector3d squares = Vector3d::Zero();
  double area = 0;
  for (int i = 0; i < 3; ++i) {  // the two faces across axis i
    const double pair = 8 * h.prod() / h[i];
    area += pair;
    for (int k = 0; k < 3; ++k) squares[k] += pair * h[k] * h[k] / (k == i ? 1 : 3);
  }
  return of(area, squares);
}

SurfaceMoments surface(const Sphere& s) {
  const double area = 4 * pi * s.radius * s.radius;
  return of(area, Vector3d::Constant(area * s.radius * s.radius / 3));
}

SurfaceMoments surface(const Cylinder& c) {
  const double r = c.radius, h = c.length / 2, tube = 4 * pi * r * h, discs = 2 * pi * r * r;
  const double across = tube * r * r / 2 + discs * r * r / 4;
  return of(tube + discs, {across, across, tube * h * h / 3 + discs * h * h});
}

// (heights on a half sphere are uniformly distributed: Archimedes)
SurfaceMoments surface(const Capsule& c) {
  const double r = c.radius, h = c.length / 2, tube = 4 * pi * r * h, caps = 4 * pi * r * r;
  const double across = tube * r * r / 2 + caps * r * r / 3;
  return of(tube + caps, {across, across, tube * h * h / 3 + caps * (h * h + h * r + r * r / 3)});
}

SurfaceMoments surface(const Cone& c) {
  const double r = c.radius, l = c.length, side = pi * r * std::hypot(r, l), base = pi * r * r;
  const double across = side * r * r / 4 + base * r * r / 4;
  return of(side + base, {across, across, side * l * l / 6}, side / (side + base) * l / 3);
}

// x = radii * u with u on the unit sphere, whose area element grows by |(bc, ca, ab) * u|. Simpson's rule
// along z; the equal steps around z are exact to rounding.
SurfaceMoments surface(const Ellipsoid& e) {
  constexpr int along = 400, around = 128;
  const Vector3d a = e.radii, growth = a.prod() * a.cwiseInverse();
  SurfaceMoments out;
  for (int i = 0; i <= along; ++i) {
    const double z = -1 + 2. * i / along, r = std::sqrt(std::max(0., 1 - z * z));
    const double weight = (i == 0 || i == along ? 1 : i % 2 ? 4 : 2) * (2. / along) / 3 * (2 * pi / around);
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * pi * k / around;
      const Vector3d u(r * std::cos(angle), r * std::sin(angle), z);
      const double area = weight * growth.cwiseProduct(u).norm();
      out.area += area;
      out.second.diagonal() += area * a.cwiseProduct(u).cwiseAbs2();
    }
  }
  return out;
}

SurfaceMoments surface(const ClosedMesh& mesh) {
  SurfaceMoments out;
  for (const auto& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices[static_cast<std::size_t>(t[0])],
                   &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                   &c = mesh.vertices[static_cast<std::size_t>(t[2])];
    const double area = (b - a).cross(c - a).norm() / 2;
    const Vector3d sum = a + b + c;
    out.area += area;
    out.first += area * sum / 3;
    out.second +=
        area / 12 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  return out;
}

}  // namespace

Inertial shell_inertial(const Form& form) {
  const SurfaceMoments all = std::visit([](const auto& one) { return surface(one); }, form);
  Inertial out;
  out.mass = all.area;
  if (!(all.area > 0)) return out;
  out.centre = all.first / all.area;
  const Matrix3d second = all.second - all.first * out.centre.transpose();
  out.tensor = second.trace() * Matrix3d::Identity() - second;
  return out;
}

}  // namespace borelli
