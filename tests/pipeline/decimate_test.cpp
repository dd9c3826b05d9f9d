// Decimation: distances measured independently, and topology.
#include "pipeline/export/decimate.hpp"

#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace borelli {
namespace {

using Eigen::Vector3d;

// a torus of n by m quads, two triangles each; closed, of genus 1
TriangleSurface torus(std::uint32_t n, std::uint32_t m, double R, double r) {
  TriangleSurface s;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < m; ++j) {
      const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / m;
      s.points.emplace_back((R + r * std::cos(v)) * std::cos(u), (R + r * std::cos(v)) * std::sin(u),
                            r * std::sin(v));
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % n * m + j % m; };
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < m; ++j) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return s;
}

void add_octahedron(TriangleSurface& s, const Vector3d& centre, double radius) {
  const auto first = static_cast<std::uint32_t>(s.points.size());
  for (int c = 0; c < 3; ++c)
    for (const double sign : {1.0, -1.0}) s.points.push_back(centre + sign * radius * Vector3d::Unit(c));
  for (const std::uint32_t x : {0u, 1u})
    for (const std::uint32_t y : {2u, 3u})
      for (const std::uint32_t z : {4u, 5u}) {
        const bool even = (x + y + z) % 2 == 0;
        s.triangles.push_back({first + x, first + (even ? y : z), first + (even ? z : y)});
      }
}

// The largest distance of points of `from` to `to`, by VTK's search for the nearest triangle.
double farthest(const TriangleSurface& from, const TriangleSurface& to) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const auto& p : to.points) points->InsertNextPoint(p.data());
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : to.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    triangles->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(triangles);
  vtkNew<vtkStaticCellLocator> locator;
  locator->SetDataSet(surface);
  locator->BuildLocator();
  vtkNew<vtkGenericCell> cell;
  double worst = 0;
  for (const auto& p : from.points) {
    double closest[3], squared = 0;
    vtkIdType triangle = 0;
    int part = 0;
    locator->FindClosestPoint(p.data(), closest, cell, triangle, part, squared);
    worst = std::max(worst, squared);
  }
  return std::sqrt(worst);
}

constexpr double rounding = 1e-9;

// vertices - edges + triangles: 2 per piece, less 2 per handle
long euler(const TriangleSurface& s) {
  return static_cast<long>(s.points.size()) - static_cast<long>(s.triangles.size()) * 3 / 2 +
         static_cast<long>(s.triangles.size());
}

TEST(Decimate, KeepsToleranceAndTopology) {
  const TriangleSurface whole = torus(160, 80, 30, 10);
  ASSERT_TRUE(is_closed(whole.points.size(), whole.triangles));
  std::size_t before = whole.triangles.size();
  for (const double tolerance : {0.02, 0.1, 0.5, 2.0}) {
    const TriangleSurface fewer = decimate(whole, tolerance);
    EXPECT_TRUE(is_closed(fewer.points.size(), fewer.triangles)) << tolerance;
    EXPECT_EQ(euler(fewer), 0) << tolerance;  // one handle
    EXPECT_LE(farthest(whole, fewer), tolerance + rounding);
    EXPECT_LT(fewer.triangles.size(), before) << tolerance;
    before = fewer.triangles.size();
  }
  EXPECT_LT(before, 300u);
}

// A torus within 0.1 needs few triangles: chords of a circle of radius 10 with sagitta s are 2 sqrt(2 * 10 *
// s) long, so an inscribed mesh needs about area / (0.43 * chord^2) triangles; an optimal mesh lies half
// inside, half outside.
TEST(Decimate, NeedsFewTriangles) {
  const TriangleSurface fewer = decimate(torus(160, 80, 30, 10), 0.1);
  const double area = 4 * std::numbers::pi * std::numbers::pi * 30 * 10, chord = 2 * std::sqrt(2 * 10 * 0.1);
  EXPECT_LT(static_cast<double>(fewer.triangles.size()), area / (0.43 * chord * chord));
}

TEST(Decimate, LeavesNoLongEdges) {
  const TriangleSurface whole = torus(160, 80, 30, 10);
  const auto longest = [](const TriangleSurface& s) {
    double most = 0;
    for (const auto& t : s.triangles)
      for (std::size_t e = 0; e < 3; ++e)
        most = std::max(most, (s.points[t[e]] - s.points[t[(e + 1) % 3]]).norm());
    return most;
  };
  const TriangleSurface fewer = decimate(whole, 2, 4);
  EXPECT_LE(longest(fewer), 4);
  EXPECT_GT(longest(decimate(whole, 2)), 8);
  EXPECT_TRUE(is_closed(fewer.points.size(), fewer.triangles));
  EXPECT_LT(fewer.triangles.size(), whole.triangles.size() / 2);
  EXPECT_EQ(decimate(whole, 2, 0.5).triangles.size(), whole.triangles.size());  // edges are longer already
}

TEST(Decimate, KeepsPiecesOfAFewTriangles) {
  TriangleSurface s = torus(60, 30, 30, 10);
  add_octahedron(s, {0, 0, 0}, 0.5);
  add_octahedron(s, {0, 0, 5}, 0.5);
  ASSERT_TRUE(is_closed(s.points.size(), s.triangles));
  const TriangleSurface fewer = decimate(s, 1);
  EXPECT_TRUE(is_closed(fewer.points.size(), fewer.triangles));
  EXPECT_EQ(euler(fewer), 0 + 2 + 2);
}

// Two sheets a quarter of the tolerance apart are not joined, and noise does not break the surface
TEST(Decimate, KeepsThinAndRoughSurfacesClosed) {
  TriangleSurface flat = torus(120, 60, 30, 10);
  for (auto& p : flat.points) p.z() *= 0.01;  // 0.2 thick
  const TriangleSurface thin = decimate(flat, 0.8);
  EXPECT_TRUE(is_closed(thin.points.size(), thin.triangles));
  EXPECT_EQ(euler(thin), 0);
  EXPECT_LE(farthest(flat, thin), 0.8 + rounding);

  std::mt19937 random(5);
  TriangleSurface rough = torus(120, 60, 30, 10);
  for (auto& p : rough.points)
    p += Vector3d::NullaryExpr([&] { return 0.6 * (static_cast<double>(random() % 1000) / 1000 - 0.5); });
  const TriangleSurface fewer = decimate(rough, 0.5);
  EXPECT_TRUE(is_closed(fewer.points.size(), fewer.triangles));
  EXPECT_EQ(euler(fewer), 0);
  EXPECT_LE(farthest(rough, fewer), 0.5 + rounding);
  EXPECT_LT(fewer.triangles.size(), rough.triangles.size() / 2);
}

TEST(Decimate, HandlesTrianglesWithoutArea) {
  TriangleSurface pinched = torus(40, 20, 30, 10);
  for (std::size_t i = 20 * 5; i < 20 * 12; ++i) pinched.points[i] = {20, 20, 0};  // seven rings in one point
  const TriangleSurface fewer = decimate(pinched, 0.5);
  EXPECT_TRUE(is_closed(fewer.points.size(), fewer.triangles));
  EXPECT_LE(farthest(pinched, fewer), 0.5 + rounding);
  for (const Vector3d& p : fewer.points) EXPECT_TRUE(p.allFinite());
}

TEST(Decimate, ZeroToleranceChangesNothing) {
  const TriangleSurface whole = torus(20, 10, 30, 10);
  EXPECT_EQ(decimate(whole, 0).triangles, whole.triangles);
  EXPECT_TRUE(decimate({}, 1).triangles.empty());
}

}  // namespace
}  // namespace borelli
