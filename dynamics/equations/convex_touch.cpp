// FCL gives the direction in which the shapes are nearest, to about 1e-6. The normal is then the best of: the
// normals of faces near it; the directions to which Newton's method leads from it for each pair of near
// vertices, edges and round parts. Each is judged by the exact separation of the shapes along it.
#include "dynamics/equations/convex_touch.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "dynamics/equations/convex_features.hpp"
#include "dynamics/scene/convex_direction.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Flat = ConvexTouch::Flat;

namespace {

// Relative to the size of the pair: a face wins over a normal that separates better by no more than this.
constexpr double as_good = 1e-9;
// Lines that meet at a smaller sine touch along a line.
constexpr double along_each_other = 0.02;
// Shapes farther apart than this part of their size get no contact points.
constexpr double far_apart = 0.5;

struct Pair {
  PlacedConvex a, b;
  double size;

  double separation(const Vector3d& n) const { return n.dot(a.support(n) - b.support(n)); }
};

struct Candidate {
  Vector3d n = Vector3d::UnitZ();
  double gap = -std::numeric_limits<double>::infinity();
  Flat flat = Flat::neither;
  int face = 0;
  ConvexFeature of_a, of_b;
  bool stale = true;  ///< of_a and of_b may not be the parts that meet
};

/// The faces of a shape whose normals are near n; of shapes that overlap, all faces.
void try_faces(const Pair& pair, const PlacedConvex& shape, Flat flat, const Vector3d& n, Candidate& best) {
  const Convex& c = *shape.convex;
  const bool overlap = best.gap < 0;
  const auto test = [&](const Vector3d& N, int face) {
    const Vector3d m = shape.side * (shape.X.R * N);
    if (!overlap && m.dot(n) < 0.5) return;
    const double gap = pair.separation(m);
    if (gap <= best.gap + (best.flat == Flat::neither ? -1 : 1) * as_good * pair.size) return;
    best = {.n = m, .gap = gap, .flat = flat, .face = face, .of_a = {}, .of_b = {}, .stale = false};
  };
  for (int f = 0; f < int(c.faces.size()); ++f) test(c.faces[std::size_t(f)].normal, f);
  if (c.kind == Convex::Kind::cylinder)
    for (const double z : {-1., 1.}) test(Vector3d(0, 0, z), 0);
}

/// Newton's method for the normal at which two parts meet, from n; none: it leads nowhere.
std::optional<Vector3d> normal_of(const Pair& pair, const ConvexFeature& fa, const ConvexFeature& fb,
                                  Vector3d n) {
  Vector3d line = fa.line.isZero() ? fb.line : fa.line;
  if (!fa.line.isZero() && !fb.line.isZero()) {
    const Vector3d both = fa.line.cross(fb.line);
    const double sine = both.norm();
    if (sine >= along_each_other) return Vector3d((both.dot(n) < 0 ? -1 : 1) / sine * both);
    line = fb.line;
  }
  if (!line.isZero()) n = (n - line.dot(n) * line).normalized();
  const auto separation = [&](const Vector3d& m) {
    return m.dot(point_of(pair.a, fa, m) - point_of(pair.b, fb, m));
  };
  double before = separation(n);
  for (int i = 0; i < 30; ++i) {
    const Vector3d d = point_of(pair.a, fa, n) - point_of(pair.b, fb, n);
    const double gap = n.dot(d);
    const Matrix3d round = roundness_of(pair.a, fa, n) + roundness_of(pair.b, fb, n);
    Vector3d step;
    if (!line.isZero()) {
      const Vector3d t = n.cross(line);
      const double stiff = t.dot(round * t) + gap;
      if (!(stiff > 1e-13 * pair.size)) return std::nullopt;
      step = t.dot(d) / stiff * t;
    } else {
      const Matrix3d M =
          round + gap * (Matrix3d::Identity() - n * n.transpose()) + pair.size * n * n.transpose();
      if (!(M.determinant() > 1e-26 * pair.size * pair.size * pair.size)) return std::nullopt;
      step = M.inverse() * (d - gap * n);
    }
    if (!step.allFinite()) return std::nullopt;
    // halve a step that does not separate better
    Vector3d next = (n + step).normalized();
    double after = separation(next);
    for (int halving = 0; after < before - 1e-15 * pair.size && halving < 8; ++halving) {
      step *= 0.5;
      next = (n + step).normalized();
      after = separation(next);
    }
    if (after < before - 1e-15 * pair.size) break;  // at its rounding
    n = next;
    before = after;
    if (step.norm() < 1e-10) break;  // the next step would be about its square
  }
  return n;
}

/// The best pair of near vertices, edges and round parts.
void try_features(const Pair& pair, const Vector3d& from, Candidate& best) {
  const NearFeatures near_a = features_near(pair.a, from), near_b = features_near(pair.b, from);
  for (int i = 0; i < near_a.count; ++i)
    for (int j = 0; j < near_b.count; ++j) {
      const ConvexFeature &fa = near_a.all[std::size_t(i)], &fb = near_b.all[std::size_t(j)];
      const auto n = normal_of(pair, fa, fb, from);
      if (!n || n->dot(from) < 0.3) continue;
      const double gap = pair.separation(*n), tolerance = as_good * pair.size;
      const double assumed = n->dot(point_of(pair.a, fa, *n) - point_of(pair.b, fb, *n));
      const bool stale = assumed > gap + tolerance;
      if (gap <= best.gap + tolerance && !(best.stale && !stale && gap >= best.gap - tolerance)) continue;
      best = {.n = *n, .gap = gap, .flat = Flat::neither, .face = 0, .of_a = fa, .of_b = fb, .stale = stale};
    }
}

/// For polytopes that overlap: the normals across an edge of each. With those of their faces these are all
/// candidates for the least depth (separating axis theorem).
void try_edges(const Pair& pair, Candidate& best) {
  const std::vector<Vector3d>&of_a = pair.a.convex->edges, &of_b = pair.b.convex->edges;
  for (const Vector3d& a : of_a)
    for (const Vector3d& b : of_b) {
      const Vector3d both = (pair.a.X.R * a).cross(pair.b.X.R * b);
      const double sine = both.norm();
      if (sine < along_each_other) continue;
      for (const double sign : {-1., 1.}) {
        const Vector3d n = sign / sine * both;
        if (pair.separation(n) > best.gap + as_good * pair.size) try_features(pair, n, best);
      }
    }
}

/// Fills the slots with the corners of a polygon that lie farthest in as many directions about the normal;
/// the directions are fixed in the shape of `across`, so that a corner keeps its slot.
void fill_slots(const ConvexPolygon& polygon, const Vector3d& x, const Vector3d& y, double size,
                ConvexTouch& out) {
  int chosen[8];
  for (int k = 0; k < out.count; ++k) {
    const double angle = 0.2 + k * 2 * std::numbers::pi / out.count;
    const Vector3d along = std::cos(angle) * x + std::sin(angle) * y;
    int best = 0;
    for (int i = 1; i < polygon.count; ++i)
      if (along.dot(polygon.corners[std::size_t(i)].p) > along.dot(polygon.corners[std::size_t(best)].p))
        best = i;
    chosen[k] = best;
    const ConvexPoint& corner = polygon.corners[std::size_t(best)];
    const auto taken = [&](int j) {
      return (polygon.corners[std::size_t(chosen[j])].p - corner.p).squaredNorm() < 1e-18 * size * size;
    };
    bool twice = false;
    for (int j = 0; j < k; ++j) twice = twice || taken(j);
    if (!twice) out.points[std::size_t(k)] = corner;
  }
}

/// Two directions across the normal that are fixed in a shape.
void fixed_directions(const PlacedConvex& shape, const Vector3d& n, Vector3d& x, Vector3d& y) {
  x = shape.X.R * shape.local(n).unitOrthogonal();
  y = n.cross(x);
}

/// The contacts of a flat face with whatever lies over it; `polygon` is on the other shape, clipped to the
/// face. `height`: the face's place along the normal; `up`: 1 if the other is a. Returns whether a corner is
/// as near as the shapes are: then no other normal separates them better.
bool lay_on_face(ConvexPolygon polygon, const PlacedConvex& other, const Vector3d& x, const Vector3d& y,
                 double height, double up, double size, ConvexTouch& out) {
  const Vector3d lowest = other.support(out.normal);
  const bool whole = polygon.count > 0;
  if (!whole) polygon.add(lowest, true);
  fill_slots(polygon, x, y, size, out);
  double least = std::numeric_limits<double>::infinity();
  for (ConvexPoint& point : out.points)
    if (point.used) {
      point.gap = up * (out.normal.dot(point.p) - height);
      least = std::min(least, point.gap);
    }
  if (whole && least <= out.gap + as_good * size) return true;
  // the lowest corner is farthest in none of the directions: it takes a free slot, or else the last
  std::size_t slot = std::size_t(out.count) - 1;
  for (std::size_t k = 0; k < std::size_t(out.count); ++k)
    if (!out.points[k].used) slot = k;
  if (whole) out.points[slot] = {.used = true, .rolls = false, .p = lowest, .gap = out.gap};
  return false;
}

/// Two lines side by side, or along each other: the ends of the stretch they share.
void lay_lines(const Pair& pair, const Candidate& found, ConvexTouch& out) {
  const Vector3d &n = found.n, e = found.of_b.line;
  const Vector3d a = point_of(pair.a, found.of_a, n), b = point_of(pair.b, found.of_b, n);
  const double turn = found.of_a.line.dot(e), middle = e.dot(a - b);
  const double low = std::max(-found.of_b.half, middle - found.of_a.half),
               high = std::min(found.of_b.half, middle + found.of_a.half);
  for (int k = 0; k < 2; ++k) {
    const double s = k ? high : low;
    const Vector3d p = a + (s - middle) / turn * found.of_a.line;
    out.points[std::size_t(k)] = {.used = low <= high || k == 0, .rolls = true, .p = p, .gap = n.dot(p - b)};
  }
}

/// The contact where two parts meet, neither of them a face.
void meet(const Pair& pair, const Candidate& found, ConvexTouch& out) {
  const Vector3d& n = found.n;
  out.roundness_a = roundness_of(pair.a, found.of_a, n);
  out.roundness_b = roundness_of(pair.b, found.of_b, n);
  const Vector3d &ea = found.of_a.line, &eb = found.of_b.line;
  if (out.count > 1 && !ea.isZero() && !eb.isZero() && ea.cross(eb).norm() < along_each_other) {
    out.line_b = eb;
    return lay_lines(pair, found, out);
  }
  out.line_a = ea;
  out.line_b = eb;
  Vector3d a = point_of(pair.a, found.of_a, n);
  const Vector3d d = a - point_of(pair.b, found.of_b, n);
  // move along the line of a until the points are opposite each other
  const double cosine = ea.dot(eb), sine = 1 - cosine * cosine;
  if (!ea.isZero())
    a += (eb.isZero() ? -ea.dot(d) : sine > 1e-12 ? (cosine * eb.dot(d) - ea.dot(d)) / sine : 0) * ea;
  out.points[0] = {.used = true, .rolls = true, .p = a, .gap = found.gap};
}

/// Fills the contacts; returns whether they prove the normal (lay_on_face).
bool lay(const Pair& pair, const Candidate& found, ConvexTouch& out) {
  out.normal = found.n;
  out.gap = found.gap;
  out.flat = found.flat;
  for (ConvexPoint& point : out.points) point = {};
  if (found.flat == Flat::neither) {
    meet(pair, found, out);
    return true;
  }
  const bool on_a = found.flat == Flat::a;
  const PlacedConvex &face = on_a ? pair.a : pair.b, &other = on_a ? pair.b : pair.a;
  Vector3d x, y;
  if (out.count == 2) {  // a capsule: its ends
    x = other.X.R.col(2);
    y.setZero();
  } else {
    fixed_directions(face, found.n, x, y);
  }
  const Vector3d& n = found.n;
  (on_a ? out.roundness_b : out.roundness_a) = roundness_of(other, features_near(other, n).all[0], n);
  return lay_on_face(clipped(near_polygon(other, n), face, found.face, n), other, x, y,
                     n.dot(face.support(n)), on_a ? -1 : 1, pair.size, out);
}

}  // namespace

ConvexTouch touch_of(const Convex& a, const Pose& X_a, const Convex& b, const Pose& X_b, int count) {
  const Pair pair{{&a, X_a, -1}, {&b, X_b, 1}, a.bound + b.bound};
  ConvexTouch out;
  out.count = count;
  const Vector3d between = X_a * a.centre - X_b * b.centre;
  const double distance = between.norm();
  out.gap = distance - pair.size;
  if (distance > 0) out.normal = between / distance;
  if (out.gap > far_apart * pair.size) return out;
  if (const auto n = direction_between(a, X_a, b, X_b)) out.normal = *n;
  Candidate best{.n = out.normal, .gap = pair.separation(out.normal), .of_a = {}, .of_b = {}};
  best.of_a = features_near(pair.a, best.n).all[0];
  best.of_b = features_near(pair.b, best.n).all[0];
  const Vector3d from = out.normal;
  try_faces(pair, pair.b, Flat::b, from, best);
  try_faces(pair, pair.a, Flat::a, from, best);
  if (best.gap < 0) try_edges(pair, best);
  if (best.flat != Flat::neither && lay(pair, best, out)) return out;
  Vector3d start = best.gap < 0 ? best.n : from;
  for (int round = 0; round < 4; ++round) {  // other parts may be near the better normal
    try_features(pair, start, best);
    if ((best.n - start).norm() < 1e-12) break;
    start = best.n;
  }
  lay(pair, best, out);
  return out;
}

ConvexTouch touch_of_plane(const Convex& a, const Pose& X_a, const Vector3d& on, const Vector3d& normal,
                           const Vector3d& across, int count) {
  const PlacedConvex shape{&a, X_a, -1};
  ConvexTouch out;
  out.count = count;
  out.flat = Flat::b;
  out.normal = normal;
  out.gap = normal.dot(shape.support(normal) - on);
  out.roundness_a = roundness_of(shape, features_near(shape, normal).all[0], normal);
  const Vector3d x = count == 2 ? Vector3d(X_a.R.col(2)) : across,
                 y = count == 2 ? Vector3d(Vector3d::Zero()) : Vector3d(normal.cross(across));
  lay_on_face(near_polygon(shape, normal), shape, x, y, normal.dot(on), 1, 2 * a.bound, out);
  return out;
}

}  // namespace borelli
