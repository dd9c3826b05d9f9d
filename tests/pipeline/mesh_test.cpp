// Meshes of bodies whose surface is known exactly, on grids of every kind.
#include "pipeline/export/mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// a map with label 1 where `inside` (of a patient point, mm) holds
LabelMap voxelised(const Grid& grid, const std::function<bool(const Vector3d&)>& inside) {
  LabelMap map;
  map.grid = grid;
  map.names = {"outside", "body"};
  map.voxels.reserve(grid.count());
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i) map.voxels.push_back(inside(grid.point(i, j, k)));
  return map;
}

// a grid with the given axes that holds a ball of `radius` mm around the patient point (100, -50, 900)
const Vector3d middle(100, -50, 900);
Grid around(const Matrix3d& axes, double radius) {
  Grid grid;
  grid.axes = axes;
  const Matrix3d to_index = axes.inverse();
  Vector3d first;
  for (int c = 0; c < 3; ++c) {
    const double half = to_index.row(c).norm() * radius + 2.3;  // 2.3: margin
    grid.size[static_cast<std::size_t>(c)] = static_cast<std::int64_t>(2 * half) + 1;
    first[c] = half;
  }
  grid.origin = middle - axes * first;
  return grid;
}

struct Distances {
  double rms = 0, farthest = 0;  // mm
};

// distances of points spread over the triangles from the exact surface
Distances distances(const Mesh& mesh, const std::function<double(const Vector3d&)>& from_surface) {
  Distances d;
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = 1e3 * mesh.points[t[0]].cast<double>(), b = 1e3 * mesh.points[t[1]].cast<double>(),
                   c = 1e3 * mesh.points[t[2]].cast<double>();
    const double own = (b - a).cross(c - a).norm() / 2;
    for (const Vector3d& weight :
         {Vector3d(1, 1, 1), Vector3d(4, 1, 1), Vector3d(1, 4, 1), Vector3d(1, 1, 4)}) {
      const double off = from_surface((weight[0] * a + weight[1] * b + weight[2] * c) / weight.sum());
      d.rms += own / 4 * off * off;
      d.farthest = std::max(d.farthest, std::abs(off));
    }
    area += own;
  }
  d.rms = std::sqrt(d.rms / area);
  return d;
}

double area_of(const Mesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.points[t[0]].cast<double>(), b = mesh.points[t[1]].cast<double>(),
                   c = mesh.points[t[2]].cast<double>();
    area += (b - a).cross(c - a).norm() / 2;
  }
  return area;
}

struct GridCase {
  const char* name;
  Matrix3d axes;
};
void PrintTo(const GridCase& c, std::ostream* out) { *out << c.name; }

Matrix3d oblique(const Vector3d& spacing, double sheared, bool mirrored) {
  Matrix3d shape = spacing.asDiagonal();
  shape(1, 2) = sheared;
  if (mirrored) shape.col(0) *= -1;
  return Eigen::AngleAxisd(0.5, Vector3d(1, -2, 2).normalized()).toRotationMatrix() * shape;
}

class MeshOfASphere : public ::testing::TestWithParam<GridCase> {};

// Without decimation. A voxel's position is known to half a voxel; smoothing averages over many. Measured on
// these grids: rms 0.05 to 0.08, largest 0.2 to 0.45 of the largest spacing. The volume is restored to that
// of the voxels.
TEST_P(MeshOfASphere, LiesOnItsSurface) {
  const double radius = 40;
  const Grid grid = around(GetParam().axes, radius);
  const LabelMap map = voxelised(grid, [&](const Vector3d& p) { return (p - middle).norm() < radius; });
  const auto meshes = part_meshes(map, {.tolerance = 0});
  ASSERT_TRUE(meshes) << meshes.error().message();
  ASSERT_EQ(meshes->size(), 1u);
  const Mesh& mesh = meshes->front();
  EXPECT_EQ(mesh.name, "body");
  EXPECT_TRUE(is_closed(mesh));
  const auto d = distances(mesh, [&](const Vector3d& p) { return (p - middle).norm() - radius; });
  const double voxel = grid.spacing().maxCoeff();
  EXPECT_LT(d.rms, 0.1 * voxel) << GetParam().name;
  EXPECT_LT(d.farthest, 0.5 * voxel) << GetParam().name;
  const double voxels = static_cast<double>(std::ranges::count(map.voxels, 1)) * grid.voxel_volume() * 1e-9;
  EXPECT_NEAR(enclosed_volume(mesh) / voxels, 1, 1e-4);  // positive: outward, also in a mirrored grid
  // ripples of a few degrees make the surface larger by the square of their slope
  EXPECT_NEAR(area_of(mesh) / (4 * std::numbers::pi * 0.04 * 0.04), 1, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Grids, MeshOfASphere,
                         ::testing::Values(GridCase{"cubic", Vector3d(2, 2, 2).asDiagonal()},
                                           GridCase{"anisotropic", Vector3d(2, 2, 3).asDiagonal()},
                                           GridCase{"thick slices", Vector3d(1, 1, 4).asDiagonal()},
                                           GridCase{"oblique", oblique({1.5, 2, 2.5}, 0, false)},
                                           GridCase{"sheared", oblique({2, 2, 2.5}, 0.9, false)},
                                           GridCase{"mirrored", oblique({2, 2, 2.5}, 0.5, true)}),
                         [](const auto& one) {
                           std::string name = one.param.name;
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });

// Parts thinner than the tolerance, and slices thicker than it.
TEST(PartMeshes, KeepTheirVolumeWhateverTheTolerance) {
  const auto ball = [](double radius) {
    return [radius](const Vector3d& p) { return (p - middle).norm() < radius; };
  };
  const auto disc = [](const Vector3d& p) {
    return (p - middle).norm() < 40 && std::abs((p - middle).dot(Vector3d(0.6, 0, 0.8))) < 5;
  };
  const Matrix3d fine = 2 * Matrix3d::Identity();
  const Matrix3d slices = Vector3d(0.5, 2, 16).asDiagonal();
  const struct {
    LabelMap map;
    const char* what;
  } cases[] = {{voxelised(around(fine, 9), ball(9)), "ball"},
               {voxelised(around(fine, 40), disc), "disc"},
               {voxelised(around(slices, 60), ball(60)), "ball in slices"}};
  for (const auto& [map, what] : cases) {
    const auto voxels = std::count(map.voxels.begin(), map.voxels.end(), 1);
    const double volume = 1e-9 * double(voxels) * map.grid.voxel_volume();
    for (const double tolerance : {0., 0.001, 0.01, 0.02, 0.05, 1e3, 1e297}) {
      const auto meshes = part_meshes(map, {tolerance, 1, {}});
      ASSERT_TRUE(meshes) << meshes.error().message();
      ASSERT_EQ(meshes->size(), 1u);
      EXPECT_TRUE(is_closed(meshes->front())) << what << tolerance;
      EXPECT_NEAR(enclosed_volume(meshes->front()) / volume, 1, 0.005) << what << tolerance;
    }
  }
}

// The tolerance is measured against the mesh before decimation; nearest points of a sphere's mesh are along
// the radius.
TEST(Mesh, DecimationKeepsToItsTolerance) {
  const double radius = 40;
  const Grid grid = around(Vector3d(2, 2, 2).asDiagonal(), radius);
  const LabelMap map = voxelised(grid, [&](const Vector3d& p) { return (p - middle).norm() < radius; });
  const auto exact = [&](const Vector3d& p) { return (p - middle).norm() - radius; };
  const auto whole = part_meshes(map, {.tolerance = 0});
  const double own = distances(whole->front(), exact).farthest;
  std::size_t before = whole->front().triangles.size();
  for (const double tolerance : {0.0002, 0.0005, 0.001}) {
    const auto fewer = part_meshes(map, {.tolerance = tolerance});
    ASSERT_TRUE(fewer);
    const Mesh& mesh = fewer->front();
    EXPECT_TRUE(is_closed(mesh));
    EXPECT_LT(mesh.triangles.size(), before) << tolerance;
    EXPECT_LT(distances(mesh, exact).farthest, own + 1e3 * tolerance + 0.05)
        << tolerance;  // 0.05: effect of restoring the volume
    EXPECT_NEAR(enclosed_volume(mesh) / enclosed_volume(whole->front()), 1, 1e-4);
    before = mesh.triangles.size();
  }
  EXPECT_LT(before, whole->front().triangles.size() / 20);  // measured: 15092 to 500
}

// Voxels finer than the tolerance are combined into blocks; the surface stays within the tolerance of the
// body's.
TEST(Mesh, ProgressCallbackCanStopMeshing) {
  const double radius = 10;
  const Grid grid = around(Vector3d(2, 2, 2).asDiagonal(), radius);
  LabelMap map = voxelised(grid, [&](const Vector3d& p) { return (p - middle).norm() < radius; });
  map.names = {"outside", "one", "two", "three"};
  for (std::size_t o = 0; o < map.voxels.size(); ++o)
    if (map.voxels[o]) map.voxels[o] = static_cast<std::uint8_t>(1 + o % 3);
  int asked = 0;
  const auto meshes = part_meshes(map, {.threads = 1, .progress = [&](double) { return ++asked < 2; }});
  ASSERT_FALSE(meshes);
  EXPECT_EQ(meshes.error().what, "stopped on request");
  EXPECT_EQ(asked, 2);
}

TEST(Mesh, CombinesFineVoxelsInBlocks) {
  const double radius = 40;
  const auto exact = [&](const Vector3d& p) { return (p - middle).norm() - radius; };
  // blocks of 2 x 4 x 1 that do not fill the grid, on oblique axes that are not perpendicular
  const Grid grid = around(oblique({0.9, 0.5, 1.3}, 0.2, true), radius);
  const LabelMap map = voxelised(grid, [&](const Vector3d& p) { return exact(p) < 0; });
  const auto meshes = part_meshes(map, {.tolerance = 0.001});
  ASSERT_TRUE(meshes);
  const Mesh& mesh = meshes->front();
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_LT(distances(mesh, exact).farthest, 1.0);
  EXPECT_LT(distances(mesh, exact).rms, 0.5);
  EXPECT_NEAR(enclosed_volume(mesh) / (4e-9 / 3 * std::numbers::pi * std::pow(radius, 3)), 1, 5e-3);
}

// Smoothing shrinks thin shapes first, such as a finger with a radius of four voxels. Measured rms: 0.1
// voxel, mostly at the round ends.
TEST(Mesh, FingerKeepsItsThickness) {
  const double radius = 8, half = 30;
  const auto exact = [&](const Vector3d& p) {
    Vector3d q = p - middle;
    q.z() -= std::clamp(q.z(), -half, half);
    return q.norm() - radius;
  };
  const Grid grid = around(oblique({2, 2, 2}, 0, false), half + radius);
  const LabelMap map = voxelised(grid, [&](const Vector3d& p) { return exact(p) < 0; });
  const auto meshes = part_meshes(map, {.tolerance = 0});
  ASSERT_TRUE(meshes);
  const Mesh& mesh = meshes->front();
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_LT(distances(mesh, exact).rms, 0.15 * 2);
  double middle_area = 0;  // cross-section half way up, from the radii of the points near it
  int counted = 0;
  for (const auto& p : mesh.points) {
    const Vector3d q = 1e3 * p.cast<double>() - middle;
    if (std::abs(q.z()) < 15) middle_area += q.head<2>().squaredNorm() * std::numbers::pi, ++counted;
  }
  ASSERT_GT(counted, 20);
  EXPECT_NEAR(middle_area / counted / (std::numbers::pi * radius * radius), 1, 0.02);
}

// a part that the scan's border cuts is closed there too
TEST(Mesh, ClosesAtTheBorderOfTheGrid) {
  Grid grid;
  grid.size = {10, 12, 14};
  LabelMap map;
  map.grid = grid;
  map.names = {"outside", "all"};
  map.voxels.assign(grid.count(), 1);
  const auto meshes = part_meshes(map);
  ASSERT_TRUE(meshes);
  EXPECT_TRUE(is_closed(meshes->front()));
  EXPECT_NEAR(enclosed_volume(meshes->front()) / (10 * 12 * 14 * 1e-9), 1, 1e-3);
}

// Noise contains all configurations of eight voxels: the mesh is still closed and faces outwards
TEST(Mesh, NoiseGivesAClosedMesh) {
  std::mt19937 random(3);
  Grid grid;
  grid.size = {14, 15, 16};
  LabelMap map;
  map.grid = grid;
  map.names = {"outside", "one", "two", "three"};
  for (std::size_t n = 0; n < grid.count(); ++n)
    map.voxels.push_back(static_cast<std::uint8_t>(random() % 4));
  const auto meshes = part_meshes(map, {.tolerance = 0});
  ASSERT_TRUE(meshes);
  ASSERT_EQ(meshes->size(), 3u);
  for (const Mesh& mesh : *meshes) {
    EXPECT_TRUE(is_closed(mesh)) << mesh.name;
    EXPECT_GT(enclosed_volume(mesh), 0) << mesh.name;
  }
}

TEST(Mesh, HandlesSingleVoxelsAndGapsInTheLabels) {
  Grid grid;
  grid.size = {5, 5, 5};
  grid.axes = Vector3d(2, 2, 2).asDiagonal();
  LabelMap map;
  map.grid = grid;
  map.names = {"outside", "absent", "one"};
  map.voxels.assign(grid.count(), 0);
  map.at(2, 2, 2) = 2;
  const auto meshes = part_meshes(map);
  ASSERT_TRUE(meshes);
  ASSERT_EQ(meshes->size(), 1u);
  EXPECT_EQ(meshes->front().name, "one");
  EXPECT_TRUE(is_closed(meshes->front()));
  EXPECT_GT(enclosed_volume(meshes->front()), 0);
  for (const auto& p : meshes->front().points)
    EXPECT_LT((p - Eigen::Vector3f(0.004f, 0.004f, 0.004f)).norm(), 0.004f);

  map.at(1, 1, 1) = 7;
  const auto nameless = part_meshes(map);
  ASSERT_FALSE(nameless);
  EXPECT_NE(nameless.error().message().find("label 7 has voxels but no name"), std::string::npos);
}

TEST(Mesh, ClosednessTestFindsHolesAndFlippedTriangles) {
  Mesh tetrahedron{
      "t", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  EXPECT_TRUE(is_closed(tetrahedron));
  EXPECT_NEAR(enclosed_volume(tetrahedron), 1.0 / 6, 1e-7);
  Mesh turned = tetrahedron;
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_FALSE(is_closed(turned));
  tetrahedron.triangles.pop_back();
  EXPECT_FALSE(is_closed(tetrahedron));
}

}  // namespace
}  // namespace borelli
