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

/// A surface or shape at one time, in the world.
struct Placed {
  Ends ends;        // of the core's segment
  Vector3d on, up;  // of a plane: a point and the normal
};

Placed placed(const Touchable& one, const Pose& X) {
  Placed out;
  if (one.core) out.ends = ends_of(*one.core, X);
  if (one.plane) out.on = X * one.plane->on.point, out.up = X.R * one.plane->normal;
  return out;
}

double gap_over(const Placed& shape, const Placed& plane) {
  return std::min(plane.up.dot(shape.ends.a - plane.on), plane.up.dot(shape.ends.b - plane.on));
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

void judge_passing(const TouchablePairs& touchable, Trajectory& trajectory) {
  const auto& [surfaces, pairs] = touchable;
  std::map<std::string, std::size_t> numbers;
  for (std::size_t s = 0; s < trajectory.solids.size(); ++s) numbers[trajectory.solids[s]] = s;
  std::vector<Placed> at(surfaces.size());
  std::vector<char> passed(pairs.size(), 0);
  double first_time = 0;
  const std::pair<int, int>* first = nullptr;
  for (std::size_t row = 0; row < trajectory.times.size(); ++row) {
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      const auto found = numbers.find(surfaces[s].solid);
      at[s] = placed(surfaces[s], found == numbers.end() ? Pose{} : trajectory.pose(row, found->second));
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const Touchable &a = surfaces[pairs[p].first], &b = surfaces[pairs[p].second];
      if (passed[p] || (!a.core && !b.core) || (!a.core && !a.plane) || (!b.core && !b.plane)) continue;
      const Placed &A = at[pairs[p].first], &B = at[pairs[p].second];
      double gap = 0, radius = 0;
      if (a.core && b.core) {
        gap = segment_distance(A.ends.a, A.ends.b, B.ends.a, B.ends.b) - a.core->radius - b.core->radius;
        radius = std::min(a.core->radius, b.core->radius);
      } else {
        radius = (a.core ? a : b).core->radius;
        gap = (a.core ? gap_over(A, B) : gap_over(B, A)) - radius;
      }
      if (gap >= -trusted_overlap * radius) continue;
      passed[p] = 1;
      if (first) continue;
      first = &pairs[p];
      first_time = trajectory.times[row];
    }
  }
  if (!first) return;
  const auto others = std::count(passed.begin(), passed.end(), 1) - 1;
  Certificate& c = trajectory.certificate;
  const std::string sentence = fmt::format(
      "{} and {} overlap at t = {:.6g} s{}: the model lets them collide, but the scene has no contact for "
      "them",
      surfaces[first->first].name, surfaces[first->second].name, first_time,
      others > 0 ? fmt::format(", and {} other pairs then or later", others) : "");
  if (!c.trusted) return c.notes.push_back(sentence);
  c.trusted = false;
  c.reason = sentence;
  c.reason_time = first_time;
}

}  // namespace borelli
