#include "dynamics/contacts/pass_through.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <map>

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double trusted_overlap = 0.01;  // share of the radius; the same limit as for contacts

struct Ends {
  Vector3d a, b;
};

Ends ends_of(const ThickSegment& s, const Pose& X) {
  return {X * (s.centre + s.length / 2 * s.axis), X * (s.centre - s.length / 2 * s.axis)};
}

double gap_over(const ThickSegment& s, const Pose& X, const Plane& plane, const Pose& X_plane) {
  const Ends e = ends_of(s, X);
  const Vector3d n = X_plane.R * plane.normal, on = X_plane * plane.on.point;
  return std::min(n.dot(e.a - on), n.dot(e.b - on)) - s.radius;
}

double gap_between(const ThickSegment& a, const Pose& Xa, const ThickSegment& b, const Pose& Xb) {
  const Ends ea = ends_of(a, Xa), eb = ends_of(b, Xb);
  return segment_distance(ea.a, ea.b, eb.a, eb.b) - a.radius - b.radius;
}

}  // namespace

std::optional<ThickSegment> core_of(const Shape& shape) {
  // Edges of the bounding box in which the capsule is inscribed.
  Vector3d edges;
  if (const auto* sphere = std::get_if<Sphere>(&shape.form)) {
    edges.setConstant(2 * sphere->radius);
  } else if (const auto* capsule = std::get_if<Capsule>(&shape.form)) {
    edges = {2 * capsule->radius, 2 * capsule->radius, capsule->length + 2 * capsule->radius};
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape.form)) {
    edges = {2 * cylinder->radius, 2 * cylinder->radius, cylinder->length};
    // a flat disc gets a sphere as high as itself
    if (edges.z() < edges.x()) edges.setConstant(edges.z());
  } else if (const auto* ellipsoid = std::get_if<Ellipsoid>(&shape.form)) {
    edges.setConstant(2 * ellipsoid->radii.minCoeff());
  } else if (const auto* box = std::get_if<Box>(&shape.form)) {
    edges = box->size;
  } else {
    return std::nullopt;
  }
  int longest = 2;
  for (int i = 0; i < 2; ++i)
    if (edges[i] > edges[longest]) longest = i;
  ThickSegment out{.centre = shape.position, .axis = shape.orientation * Vector3d::Unit(longest)};
  out.radius = edges.minCoeff() / 2;
  out.length = edges[longest] - 2 * out.radius;
  return out;
}

double segment_distance(const Vector3d& a, const Vector3d& a_end, const Vector3d& b, const Vector3d& b_end) {
  const Vector3d u = a_end - a, v = b_end - b, w = a - b;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  const auto distance = [&](double s, double t) { return (w + s * u - t * v).norm(); };
  const auto part = [](double up, double down) { return down > 0 ? std::clamp(up / down, 0., 1.) : 0.; };
  // |d|^2 is convex in (s, t): its minimum lies inside, or on one of the four sides of the square.
  double least = std::numeric_limits<double>::infinity();
  for (const double end : {0., 1.}) {
    least = std::min(least, distance(end, part(v.dot(w + end * u), vv)));
    least = std::min(least, distance(part(u.dot(end * v - w), uu), end));
  }
  if (const double K = uu * vv - uv * uv; K > 1e-12 * uu * vv) {
    const double s = (uv * v.dot(w) - vv * u.dot(w)) / K, t = (uu * v.dot(w) - uv * u.dot(w)) / K;
    if (s > 0 && s < 1 && t > 0 && t < 1) least = std::min(least, distance(s, t));
  }
  return least;
}

void judge_passing(const std::vector<TouchablePair>& pairs, Trajectory& trajectory) {
  std::map<std::string, std::size_t> numbers;
  for (std::size_t s = 0; s < trajectory.solids.size(); ++s) numbers[trajectory.solids[s]] = s;
  const auto pose = [&](std::size_t row, const Touchable& one) {
    const auto found = numbers.find(one.solid);
    return found == numbers.end() ? Pose{} : trajectory.pose(row, found->second);
  };
  int passed = 0;
  double first_time = std::numeric_limits<double>::infinity();
  const TouchablePair* first = nullptr;
  for (const TouchablePair& pair : pairs) {
    const auto& [a, b] = pair;
    if ((!a.core && !a.plane) || (!b.core && !b.plane) || (!a.core && !b.core)) continue;
    double radius = std::numeric_limits<double>::infinity();
    for (const Touchable* one : {&a, &b})
      if (one->core) radius = std::min(radius, one->core->radius);
    for (std::size_t row = 0; row < trajectory.times.size(); ++row) {
      const Pose Xa = pose(row, a), Xb = pose(row, b);
      const double gap = a.plane   ? gap_over(*b.core, Xb, *a.plane, Xa)
                         : b.plane ? gap_over(*a.core, Xa, *b.plane, Xb)
                                   : gap_between(*a.core, Xa, *b.core, Xb);
      if (gap >= -trusted_overlap * radius) continue;
      ++passed;
      if (trajectory.times[row] < first_time) {
        first_time = trajectory.times[row];
        first = &pair;
      }
      break;
    }
  }
  if (!first) return;
  Certificate& c = trajectory.certificate;
  const std::string sentence = fmt::format(
      "{} and {} overlap at t = {:.6g} s{}: the model lets them collide, but the scene has no contact for "
      "them",
      first->a.name, first->b.name, first_time,
      passed > 1 ? fmt::format(", and {} other pairs then or later", passed - 1) : "");
  if (!c.trusted) return c.notes.push_back(sentence);
  c.trusted = false;
  c.reason = sentence;
  c.reason_time = first_time;
}

}  // namespace borelli
