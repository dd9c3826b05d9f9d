// Inertial elements of shapes against exact fractions and against 1-D quadrature over slices.
#include "dynamics/scene/shape.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

// Closed forms and exact polynomial integrals: a few dozen roundings of numbers about 1.
constexpr double rounding = 1e-14;

void expect_near(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected, double tolerance) {
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance) << "found\n"
                                                                 << found << "\nexpected\n"
                                                                 << expected;
}

Inertial filled(const Form& form, double density = 1) {
  const auto inertial = inertial_of_density({form}, density);
  EXPECT_TRUE(inertial) << inertial.error().message();
  return inertial.value_or(Inertial{});
}

// The tetrahedron of the origin and the three unit points, as in libigl's test of moments.
ClosedMesh unit_tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

ClosedMesh box_mesh(const Vector3d& low, const Vector3d& high) {
  ClosedMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(
        {i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  const std::array<std::array<int, 4>, 6> faces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : faces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

ClosedMesh moved(ClosedMesh mesh, const Matrix3d& map, const Vector3d& shift) {
  for (Vector3d& p : mesh.vertices) p = map * p + shift;
  return mesh;
}

ClosedMesh reversed(ClosedMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

ClosedMesh joined(ClosedMesh a, const ClosedMesh& b) {
  const int offset = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

// An inertia tensor's second-moment matrix, integral of x x^T dm about the centre.
Matrix3d second_moments(const Inertial& s) {
  return 0.5 * s.tensor.trace() * Matrix3d::Identity() - s.tensor;
}

// ---- exact fractions ----

TEST(Shape, BoxOfTwoByThreeByFive) {
  const Inertial box = filled(Box{{2, 3, 5}}, 7);
  EXPECT_DOUBLE_EQ(box.mass, 210);
  expect_near(box.tensor, Vector3d(595, 507.5, 227.5).asDiagonal(), 210 * rounding * 10);  // m/12 (b^2 + c^2)
}

TEST(Shape, SphereHasTwoFifths) {
  const Inertial sphere = filled(Sphere{0.5}, 3);
  EXPECT_NEAR(sphere.mass, pi / 2, rounding);
  expect_near(sphere.tensor, Matrix3d::Identity() * (pi / 2 / 10), rounding);
}

TEST(Shape, CylinderConeEllipsoidHaveKnownFractions) {
  const auto cylinder = inertial_of_mass({Cylinder{2, 6}}, 12);
  expect_near(cylinder->tensor, Vector3d(48, 48, 24).asDiagonal(),
              50 * rounding);  // m (3r^2 + l^2)/12, m r^2/2
  const auto cone = inertial_of_mass({Cone{2, 4}}, 40);
  expect_near(cone->centre, Vector3d(0, 0, 1), rounding);
  expect_near(cone->tensor, Vector3d(48, 48, 48).asDiagonal(),
              50 * rounding);  // 3/80 m (4r^2 + h^2), 3/10 m r^2
  const auto ellipsoid = inertial_of_mass({Ellipsoid{{1, 2, 3}}}, 5);
  expect_near(ellipsoid->tensor, Vector3d(13, 10, 5).asDiagonal(), 13 * rounding);  // m/5 (b^2 + c^2)
}

TEST(Shape, CapsuleWithoutLengthIsASphere) {
  expect_near(filled(Capsule{0.3, 1e-300}).tensor, filled(Sphere{0.3}).tensor, rounding);
}

TEST(Shape, UnitTetrahedronHasTheKnownFractions) {
  const Inertial t = filled(unit_tetrahedron());
  EXPECT_NEAR(t.mass, 1. / 6, rounding);
  expect_near(t.centre, Vector3d::Constant(0.25), rounding);
  // central second moments: 1/60 - 1/6/16 = 1/160 and 1/120 - 1/6/16 = -1/480, so Ixx = 1/80 and Ixy = +1/480
  Matrix3d expected = Matrix3d::Constant(1. / 480);
  expected.diagonal().setConstant(1. / 80);
  expect_near(t.tensor, expected, rounding);
}

TEST(Shape, SkewedMeshFollowsItsLinearMap) {
  // Under p -> M p + s the second moments become |det M| M C M^T for any solid, off-origin and with products.
  Matrix3d map;
  map << 2, -1, 0, 0, 3, 1, 1, 0, 1;  // determinant 5
  const Vector3d shift(10, -20, 30);
  const Inertial found = filled(moved(unit_tetrahedron(), map, shift));
  Matrix3d unit = Matrix3d::Constant(-1. / 480);
  unit.diagonal().setConstant(1. / 160);
  EXPECT_NEAR(found.mass, 5. / 6, 10 * rounding);
  expect_near(found.centre, shift + map * Vector3d::Constant(0.25), 100 * rounding);
  expect_near(second_moments(found), 5 * map * unit * map.transpose(), 100 * rounding);
  EXPECT_GT(std::abs(found.tensor(0, 1)),
            0.01);  // the test would miss products of inertia if there were none
}

TEST(Shape, MeshFarFromTheOriginKeepsItsDigits) {
  const Vector3d far(1000, 2000, -3000);
  const Inertial found = filled(box_mesh(far, far + Vector3d(0.25, 0.5, 1)));  // corners exact in binary
  expect_near(found.centre, far + Vector3d(0.125, 0.25, 0.5), 1e-12);          // one rounding of 3000
  expect_near(found.tensor, filled(Box{{0.25, 0.5, 1}}).tensor, rounding);
}

TEST(Shape, TriangleSoupEqualsIndexedMesh) {
  const ClosedMesh indexed = moved(box_mesh({0, 0, 0}, {1, 2, 3}), Matrix3d::Identity(), {0.1, 0.2, 0.3});
  ClosedMesh soup;
  for (const auto& t : indexed.triangles) {
    const int n = static_cast<int>(soup.vertices.size());
    for (const int v : t) soup.vertices.push_back(indexed.vertices[v]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  expect_near(filled(soup).tensor, filled(indexed).tensor, 1e-15);
}

TEST(Shape, CavityIsSubtracted) {
  const ClosedMesh hollow =
      joined(box_mesh({-1, -1, -1}, {1, 1, 1}), reversed(box_mesh({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5})));
  const Inertial found = filled(hollow);
  EXPECT_NEAR(found.mass, 7, 10 * rounding);
  expect_near(found.tensor, Matrix3d::Identity() * (8 * 8. / 12 - 2. / 12), 10 * rounding);
}

// ---- against quadrature over slices ----

// A solid of revolution (or with elliptic slices) cut across z: half axes a(z), b(z) of the slice.
Inertial by_slices(double low, double high, const std::function<Vector3d(double)>& half_axes) {
  // composite Simpson's rule: exact for the cubics in these slices, and of fourth order for the quartics
  const int n = 2000;
  double volume = 0, z1 = 0, z2 = 0, x2 = 0, y2 = 0;
  for (int i = 0; i <= n; ++i) {
    const double z = low + (high - low) * i / n, w = (high - low) / n / 3 *
                                                     (i == 0 || i == n ? 1
                                                      : i % 2          ? 4
                                                                       : 2);
    const Vector3d r = half_axes(z);
    const double area = pi * r[0] * r[1];
    volume += w * area, z1 += w * area * z, z2 += w * area * z * z;
    x2 += w * area * r[0] * r[0] / 4, y2 += w * area * r[1] * r[1] / 4;
  }
  const double c = z1 / volume, zz = z2 - volume * c * c;
  return {volume, {0, 0, c}, Vector3d(y2 + zz, x2 + zz, x2 + y2).asDiagonal()};
}

void expect_equal(const Inertial& found, const Inertial& expected, double tolerance) {
  EXPECT_NEAR(found.mass, expected.mass, tolerance);
  expect_near(found.centre, expected.centre, tolerance);
  expect_near(found.tensor, expected.tensor, tolerance);
}

TEST(Shape, ConeEllipsoidAndCapsuleAgreeWithQuadrature) {
  // Simpson's error on the quartic slices: (h^4/180) f'''' = (1e-3)^4/180 * 24 * pi, about 4e-13
  expect_equal(
      filled(Cone{0.7, 1.9}),
      by_slices(0, 1.9, [](double z) { return Vector3d(0.7 * (1 - z / 1.9), 0.7 * (1 - z / 1.9), 0); }),
      1e-12);
  expect_equal(filled(Ellipsoid{{0.4, 0.9, 1.1}}),
               by_slices(-1.1, 1.1,
                         [](double z) {
                           const double s = std::sqrt(std::max(0., 1 - z * z / 1.21));
                           return Vector3d(0.4 * s, 0.9 * s, 0);
                         }),
               1e-12);
  // l/2 must be a panel's boundary, where the capsule's pieces join: 0.8 of 2.0 is panel 400 of 2000
  expect_equal(filled(Capsule{0.6, 0.8}),
               by_slices(-1, 1,
                         [](double z) {
                           const double out = std::max(0., std::abs(z) - 0.4);
                           const double r = std::sqrt(std::max(0., 0.36 - out * out));
                           return Vector3d(r, r, 0);
                         }),
               1e-12);
}

TEST(Shape, SphereMeshConvergesWithTheSquareOfItsEdge) {
  const auto error = [](int n) {
    ClosedMesh mesh;  // n x 2n net of latitudes and longitudes; the poles are welded
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j < 2 * n; ++j) {
        const double u = pi * i / n, v = pi * j / n, s = i % n == 0 ? 0 : std::sin(u);
        mesh.vertices.push_back({s * std::cos(v), s * std::sin(v), std::cos(u)});
      }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * n; ++j) {
        const int a = i * 2 * n + j, b = i * 2 * n + (j + 1) % (2 * n), c = a + 2 * n, d = b + 2 * n;
        mesh.triangles.push_back({a, c, d});
        mesh.triangles.push_back({a, d, b});
      }
    return (filled(mesh).tensor - filled(Sphere{1}).tensor).norm();
  };
  const double order = std::log2(error(24) / error(48));
  EXPECT_NEAR(order, 2, 0.02);
}

// ---- placement ----

TEST(Shape, PlacementGivesProductsOfInertia) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
  const Vector3d shift(0.3, -0.4, 1.2);
  const auto placed = inertial_of_density({Box{{0.2, 0.5, 0.9}}, shift, turn}, 1000);
  // the same box as a mesh with transformed corners
  const auto mesh = inertial_of_density(
      {moved(box_mesh({-0.1, -0.25, -0.45}, {0.1, 0.25, 0.45}), turn.matrix(), shift)}, 1000);
  ASSERT_TRUE(placed && mesh);
  expect_equal(*placed, *mesh, 1e-12);  // masses of 90 kg: a few roundings of 1e-14
  EXPECT_GT(std::abs(placed->tensor(0, 1)), 0.1);
}

// ---- refusals ----

void expect_refused(const Form& form, const std::string& said) {
  const auto answer = inertial_of_density({form}, 1);
  ASSERT_FALSE(answer) << "expected a refusal that says: " << said;
  EXPECT_NE(answer.error().message().find(said), std::string::npos) << answer.error().message();
  EXPECT_EQ(answer.error().kind, Error::Kind::use);
}

TEST(Shape, RefusesImpossibleSizes) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  expect_refused(Box{{1, -2, 3}}, "size[1] is -2");
  expect_refused(Sphere{0}, "sphere: radius is 0");
  expect_refused(Cylinder{1, nan}, "length is nan");
  expect_refused(Ellipsoid{{1, inf, 1}}, "radii[1] is inf");
  expect_refused(Capsule{-1, 1}, "capsule: radius is -1");
  EXPECT_FALSE(inertial_of_density({Sphere{1}}, -1));
  EXPECT_FALSE(inertial_of_mass({Sphere{1}}, nan));
  EXPECT_FALSE(inertial_of_mass({Sphere{1}, Vector3d::Zero(), {2, 0, 0, 0}}, 1));
}

TEST(Shape, RefusesMeshesThatEncloseNoSolid) {
  ClosedMesh open = unit_tetrahedron();
  open.triangles.pop_back();
  expect_refused(open, "is not closed");
  ClosedMesh one_turned = unit_tetrahedron();
  std::swap(one_turned.triangles[0][0], one_turned.triangles[0][1]);
  expect_refused(one_turned, "opposite orientations");
  expect_refused(reversed(unit_tetrahedron()), "faces inwards");
  expect_refused(ClosedMesh{}, "has no triangles");
  expect_refused(ClosedMesh{{{0, 0, 0}}, {{0, 0, 0}}}, "no triangles that enclose");
  expect_refused(ClosedMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}}, "vertex 3");
  expect_refused(ClosedMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}}, "encloses no volume");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused(ClosedMesh{{{0, 0, 0}, {1, 0, 0}, {0, nan, 0}}, {{0, 1, 2}}}, "vertex 2 is not finite");
}

TEST(Shape, RefusesNestedOutwardShells) {
  const ClosedMesh outer = box_mesh({0, 0, 0}, {4, 4, 4}), inner = box_mesh({1, 1, 1}, {2, 2, 2});
  expect_refused(joined(outer, inner), "inside another one");
  expect_refused(joined(outer, reversed(moved(inner, Matrix3d::Identity(), {9, 0, 0}))), "faces inwards");
  EXPECT_TRUE(inertial_of_density({joined(outer, moved(inner, Matrix3d::Identity(), {9, 0, 0}))}, 1));
}

}  // namespace
}  // namespace borelli
