#include "dynamics/equations/convex_features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Faces that deviate less than this from the contact plane belong to the surface that may touch.
const double near_face = std::cos(15 * std::numbers::pi / 180);
// A cylinder or capsule whose axis is this near to the normal stands, else it lies.
constexpr double stands = 0.7;
// Sine of the tilt of a standing cylinder below which its lowest point counts as fixed in it: it may run
// around the rim at any speed.
constexpr double upright = 0.05;
constexpr int rim_corners = 8, cap_corners = 24;

Vector3d on_rim(const Convex& c, double angle, double z) {
  return {c.radii.x() * std::cos(angle), c.radii.x() * std::sin(angle), z};
}

ConvexPolygon near_cylinder(const PlacedConvex& shape, const Vector3d& n) {
  ConvexPolygon out;
  const Convex& c = *shape.convex;
  const Vector3d N = shape.local(n);
  const double across = std::hypot(N.x(), N.y()), lowest = across > 0 ? std::atan2(N.y(), N.x()) : 0;
  if (std::abs(N.z()) < stands) {
    for (const double z : {-c.half, c.half}) out.add(shape.X * on_rim(c, lowest, z), true);
    return out;
  }
  const double z = N.z() < 0 ? -c.half : c.half;
  if (across > 1e-12) out.add(shape.X * on_rim(c, lowest, z), across > upright);
  // then fixed corners all around; one beside the lowest point could take its place among the contacts, and the
  // depth would be less by up to their difference in height
  const double step = 2 * std::numbers::pi / rim_corners, first = std::ceil(lowest / step + 1e-3) * step;
  for (int k = 0; k < rim_corners; ++k) out.add(shape.X * on_rim(c, first + k * step, z));
  return out;
}

// Corners of the faces near the contact plane, those farthest in 16 directions.
ConvexPolygon near_faces(const PlacedConvex& shape, const Vector3d& n) {
  const Convex& c = *shape.convex;
  const Vector3d N = shape.local(n);
  double most = -2;
  for (const ConvexFace& face : c.faces) most = std::max(most, face.normal.dot(N));
  const double enough = std::min(most, near_face);
  ConvexPolygon out;
  int alone = -1, faces = 0;
  for (int f = 0; f < int(c.faces.size()); ++f)
    if (c.faces[std::size_t(f)].normal.dot(N) >= enough) {
      alone = f;
      ++faces;
    }
  if (const auto& corners = c.faces[std::size_t(alone)].corners; faces == 1 && corners.size() <= 16) {
    for (const int v : corners) out.add(shape.X * c.vertices[std::size_t(v)]);
    return out;
  }
  const Vector3d x = N.unitOrthogonal(), y = N.cross(x);
  int last = -1, first = -1;
  for (int k = 0; k < 16; ++k) {
    const double angle = 0.1 + k * std::numbers::pi / 8;
    const Vector3d along = std::cos(angle) * x + std::sin(angle) * y;
    int best = -1;
    double farthest = 0;
    for (const ConvexFace& face : c.faces) {
      if (face.normal.dot(N) < enough) continue;
      for (const int v : face.corners)
        if (const double d = along.dot(c.vertices[std::size_t(v)]); best < 0 || d > farthest) {
          best = v;
          farthest = d;
        }
    }
    if (best == last || best == first) continue;
    if (first < 0) first = best;
    last = best;
    out.add(shape.X * c.vertices[std::size_t(best)]);
  }
  return out;
}

}  // namespace

NearFeatures features_near(const PlacedConvex& shape, const Vector3d& n) {
  const Convex& c = *shape.convex;
  NearFeatures out;
  if (c.kind != Convex::Kind::polytope) {
    out.add({});
    if (c.kind == Convex::Kind::cylinder && std::abs(shape.local(n).z()) < stands)
      out.add({.flank = true, .line = shape.X.R.col(2), .middle = shape.X.p, .half = c.half});
    return out;
  }
  const int v = c.farthest_vertex(shape.local(n));
  const Vector3d p = shape.X * c.vertices[std::size_t(v)];
  out.add({.vertex = v});
  for (const int end : c.neighbours[std::size_t(v)]) {
    const Vector3d edge = shape.X * c.vertices[std::size_t(end)] - p;
    const double length = edge.norm();
    if (std::abs(edge.dot(n)) > 0.8 * length) continue;
    out.add({.vertex = v, .line = edge / length, .middle = p + 0.5 * edge, .half = 0.5 * length});
  }
  return out;
}

Vector3d point_of(const PlacedConvex& shape, const ConvexFeature& feature, const Vector3d& n) {
  const Convex& c = *shape.convex;
  if (feature.flank) {
    const Vector3d N = shape.local(n);
    return shape.X * Vector3d(c.radii.x() * Vector3d(N.x(), N.y(), 0).normalized());
  }
  if (feature.vertex < 0) return shape.support(n);
  const Vector3d swelling = shape.side * c.radii.x() * n;
  if (feature.half > 0) return feature.middle + swelling;
  return shape.X * c.vertices[std::size_t(feature.vertex)] + swelling;
}

Matrix3d roundness_of(const PlacedConvex& shape, const ConvexFeature& feature, const Vector3d& n) {
  const Convex& c = *shape.convex;
  const Matrix3d tangent = Matrix3d::Identity() - n * n.transpose();
  if (feature.vertex >= 0) return c.radii.x() * (tangent - feature.line * feature.line.transpose());
  const Vector3d N = shape.local(n);
  if (c.kind == Convex::Kind::ellipsoid) {  // second derivatives of the support function |radii * N|
    const Vector3d squares = c.radii.cwiseAbs2(), g = squares.cwiseProduct(N);
    const double h = c.radii.cwiseProduct(N).norm();
    const Matrix3d local = (Matrix3d(squares.asDiagonal()) - g * g.transpose() / (h * h)) / h;
    return shape.X.R * local * shape.X.R.transpose();
  }
  const double across = std::hypot(N.x(), N.y());
  if (across < 1e-12) return Matrix3d::Zero();
  const Vector3d around = shape.X.R * Vector3d(-N.y(), N.x(), 0) / across;
  return c.radii.x() / across * around * around.transpose();
}

ConvexPolygon near_polygon(const PlacedConvex& shape, const Vector3d& n) {
  const Convex& c = *shape.convex;
  if (c.kind == Convex::Kind::cylinder) return near_cylinder(shape, n);
  if (c.kind == Convex::Kind::polytope && !c.faces.empty()) return near_faces(shape, n);
  ConvexPolygon out;
  const Vector3d swelling = shape.side * c.radii.x() * n;
  if (c.vertices.size() == 2 && std::abs(shape.local(n).z()) < stands)
    for (const Vector3d& v : c.vertices) out.add(shape.X * v + swelling, true);
  else
    out.add(shape.support(n), true);
  return out;
}

ConvexPolygon clipped(const ConvexPolygon& polygon, const PlacedConvex& shape, int face, const Vector3d& n) {
  const Convex& c = *shape.convex;
  const bool polytope = c.kind == Convex::Kind::polytope;
  const int sides = polytope ? int(c.faces[std::size_t(face)].corners.size()) : cap_corners;
  const Vector3d N = shape.local(n);
  const auto corner = [&](int k) -> Vector3d {
    if (polytope)
      return shape.X * c.vertices[std::size_t(c.faces[std::size_t(face)].corners[std::size_t(k % sides)])];
    const double z = N.z() < 0 ? -c.half : c.half, turn = 2 * std::numbers::pi * (k % sides) / sides;
    return shape.X * on_rim(c, N.z() < 0 ? -turn : turn, z);
  };
  const Vector3d out_of_face = shape.side * n;
  ConvexPolygon now = polygon;
  for (int k = 0; k < sides && now.count > 0; ++k) {  // Sutherland and Hodgman 1974
    const Vector3d at = corner(k), inwards = out_of_face.cross(corner(k + 1) - at).normalized();
    const ConvexPolygon before = now;
    now.count = 0;
    for (int i = 0; i < before.count; ++i) {
      const ConvexPoint &one = before.corners[std::size_t(i)],
                        &next = before.corners[std::size_t((i + 1) % before.count)];
      const double here = inwards.dot(one.p - at), there = inwards.dot(next.p - at);
      if (here >= 0) now.add(one.p, one.rolls);
      if ((here < 0) != (there < 0) && (here != 0 && there != 0))
        now.add(one.p + here / (here - there) * (next.p - one.p), one.rolls && next.rolls);
    }
  }
  return now;
}

}  // namespace borelli
