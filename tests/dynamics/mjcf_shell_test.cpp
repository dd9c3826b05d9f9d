// Shells compared with closed forms, fine triangulations and thin layers. (MuJoCo 2.2 has shells of meshes
// alone.)
#include "dynamics/formats/mjcf_shell.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "dynamics/formats/model_file.hpp"
#include "tests/dynamics/scenes.hpp"
#include "tests/dynamics/test_folder.hpp"

namespace borelli::test {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// A surface of revolution in the unit sphere's angles, scaled to half axes.
ClosedMesh triangulated(const Vector3d& radii, int n) {
  ClosedMesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k < 2 * n; ++k) {
      const double polar = pi * i / n, around = pi * k / n;
      mesh.vertices.push_back(radii.cwiseProduct(
          Vector3d(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar))));
    }
  const auto at = [&](int i, int k) { return i * 2 * n + k % (2 * n); };
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 2 * n; ++k) {
      mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
      mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  return mesh;
}

void expect_near(const Inertial& a, const Inertial& b, double share) {
  EXPECT_NEAR(a.mass, b.mass, share * b.mass);
  EXPECT_LT((a.centre - b.centre).norm(), share);
  EXPECT_LT((a.tensor - b.tensor).norm(), share * b.tensor.norm());
}

TEST(MjcfShell, EllipsoidEqualsItsTriangulation) {
  // triangles of n steps err by about (pi / n)^2 / 6; Richardson's extrapolation leaves the fourth power
  for (const Vector3d& radii : {Vector3d(.3, .2, .1), Vector3d(1, 1, 1), Vector3d(.1, .1, .5)}) {
    const Inertial coarse = shell_inertial(triangulated(radii, 100)),
                   fine = shell_inertial(triangulated(radii, 200)), ours = shell_inertial(Ellipsoid{radii});
    EXPECT_NEAR(ours.mass, (4 * fine.mass - coarse.mass) / 3, 1e-5 * ours.mass);
    EXPECT_LT((ours.tensor - (4 * fine.tensor - coarse.tensor) / 3).norm(), 1e-5 * ours.tensor.norm());
  }
  expect_near(shell_inertial(Ellipsoid{Vector3d::Constant(.7)}), shell_inertial(Sphere{.7}), 1e-9);
}

TEST(MjcfShell, ThinSolidsApproachIt) {
  // the difference of two solids that are a thin layer apart
  const double d = 1e-5;
  const auto layer = [&](const Form& outer, const Form& inner) {
    const auto solid = [](const Form& form) {
      return inertial_of_density({form, Vector3d::Zero(), Eigen::Quaterniond::Identity()}, 1).value();
    };
    Inertial out = solid(outer);
    const Inertial in = solid(inner);
    out.mass = (out.mass - in.mass) / d;
    out.tensor = (out.tensor - in.tensor) / d;
    return out;
  };
  const Vector3d all = Vector3d::Constant(d);
  expect_near(shell_inertial(Box{{.3, .4, .5}}),
              layer(Box{Vector3d(.3, .4, .5) + all}, Box{Vector3d(.3, .4, .5) - all}), 1e-6);
  expect_near(shell_inertial(Sphere{.3}), layer(Sphere{.3 + d / 2}, Sphere{.3 - d / 2}), 1e-6);
  expect_near(shell_inertial(Cylinder{.3, .8}),
              layer(Cylinder{.3 + d / 2, .8 + d}, Cylinder{.3 - d / 2, .8 - d}), 1e-6);
  expect_near(shell_inertial(Capsule{.3, .8}), layer(Capsule{.3 + d / 2, .8}, Capsule{.3 - d / 2, .8}), 1e-6);
}

TEST(MjcfShell, GeomsWeighAsTheirSurface) {
  const Folder folder;
  const auto body = [&](const std::string& geom) {
    return need(read_model(
                    folder.write("m.xml", "<mujoco><worldbody><body><freejoint/><geom shellinertia='true' " +
                                              geom + "/></body></worldbody></mujoco>")))
        .scene.solids.at(0)
        .inertials.at(0);
  };
  const Inertial ball = body("size='.3' density='30' pos='1 2 3'");
  EXPECT_NEAR(ball.mass, 30 * 4 * pi * .09, 1e-12);
  EXPECT_LT((ball.centre - Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((ball.tensor - 2. / 3 * ball.mass * .09 * Eigen::Matrix3d::Identity()).norm(), 1e-12);
  // a cube of six plates, seen along any axes: I = 5/18 m edge^2
  const Inertial cube = body("type='box' size='.1 .1 .1' mass='2' euler='10 20 30'");
  EXPECT_NEAR(cube.mass, 2, 1e-14);
  EXPECT_LT((cube.tensor - 5. / 18 * 2 * .04 * Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

}  // namespace
}  // namespace borelli::test
