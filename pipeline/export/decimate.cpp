#include "pipeline/export/decimate.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <optional>
#include <queue>
#include <utility>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Triangle = std::array<std::uint32_t, 3>;

// Solves m x = y for a positive definite m, whose lower triangle is used. Same pivots and operations in the
// same order as Eigen's ldlt().solve(), without its loops over dynamic sizes.
Vector3d solved(const Matrix3d& m, const Vector3d& y) {
  double d0 = m(0, 0), d1 = m(1, 1), d2 = m(2, 2), l10 = m(1, 0), l20 = m(2, 0), l21 = m(2, 1);
  double x0 = y[0], x1 = y[1], x2 = y[2];
  const bool second_leads = d1 > d0 && d1 >= d2, third_leads = d2 > d0 && d2 > d1;
  if (second_leads) std::swap(d0, d1), std::swap(l20, l21), std::swap(x0, x1);
  if (third_leads) std::swap(d0, d2), std::swap(l10, l21), std::swap(x0, x2);
  l10 /= d0, l20 /= d0;
  const bool swap_rest = d2 > d1;
  if (swap_rest) std::swap(d1, d2), std::swap(l10, l20), std::swap(x1, x2);
  d1 -= l10 * (d0 * l10);
  l21 = (l21 - l20 * (d0 * l10)) / d1;
  d2 -= l20 * (d0 * l20) + l21 * (d1 * l21);

  x1 -= l10 * x0;
  x2 -= l20 * x0 + l21 * x1;
  x0 /= d0, x1 /= d1, x2 /= d2;
  x1 -= l21 * x2;
  x0 -= l10 * x1 + l20 * x2;
  if (swap_rest) std::swap(x1, x2);
  if (third_leads) std::swap(x0, x2);
  if (second_leads) std::swap(x0, x1);
  return {x0, x1, x2};
}

/// Sum over planes of weight * squared distance: x' A x + 2 b' x + c.
struct Quadric {
  Matrix3d A = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double c = 0, weight = 0;

  void add_plane(const Vector3d& normal, const Vector3d& point, double w) {
    const double d = -normal.dot(point);
    A += w * normal * normal.transpose();
    b += w * d * normal;
    c += w * d * d;
    weight += w;
  }
  Quadric& operator+=(const Quadric& other) {
    A += other.A, b += other.b, c += other.c, weight += other.weight;
    return *this;
  }
  double error(const Vector3d& x) const { return std::max(0.0, x.dot(A * x) + 2 * b.dot(x) + c); }

  // Point of least error. On a plane or a ridge it is not unique: a regularisation of a thousandth of the
  // weight pulls it to `near`.
  Vector3d best(const Vector3d& near) const {
    const double pull = 1e-3 * weight;
    return solved(A + pull * Matrix3d::Identity(), pull * near - b);
  }
};

struct Collapse {
  double cost = 0;
  std::uint32_t a = 0, b = 0;
  std::uint32_t stamp = 0;  // stamps of both ends when computed: later changes make it stale

  bool operator<(const Collapse& other) const { return cost > other.cost; }  // least cost on top
};

/// A simplified surface, and for each input point its point in the result.
struct Fewer {
  TriangleSurface surface;
  std::vector<std::uint32_t> home;
};

class Decimation {
 public:
  // `locked` points stay. Coordinates are relative to a near origin, so that squared distances keep their
  // digits.
  Decimation(const TriangleSurface& surface, double reach, double longest_edge,
             const std::vector<bool>& locked)
      : near_(surface.points.front()),
        reach_(reach),
        longest_edge_(longest_edge),
        locked_(locked),
        triangles_(surface.triangles),
        triangles_of_(surface.points.size()),
        quadrics_(surface.points.size()),
        stamps_(surface.points.size(), 0),
        into_(surface.points.size()),
        marks_(surface.points.size(), 0) {
    std::iota(into_.begin(), into_.end(), 0u);
    points_.reserve(surface.points.size());
    for (const Vector3d& p : surface.points) points_.push_back(p - near_);
    for (auto& around : triangles_of_) around.reserve(8);  // six on average
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      const auto [normal, area] = plane(triangles_[t]);
      for (const std::uint32_t v : triangles_[t]) {
        triangles_of_[v].push_back(t);
        if (area > 0) quadrics_[v].add_plane(normal, points_[v], area);
      }
    }
  }

  // Collapses the cheapest edge first, until every remaining edge costs more than the reach allows.
  Fewer run() {
    for (const Triangle& t : triangles_)
      for (std::size_t e = 0; e < 3; ++e)
        if (t[e] < t[(e + 1) % 3]) consider(t[e], t[(e + 1) % 3]);
    while (!queue_.empty()) {
      const Collapse next = queue_.top();
      queue_.pop();
      if (gone(next.a) || gone(next.b) || stamps_[next.a] + stamps_[next.b] != next.stamp) continue;
      const Vector3d place = joined(next.a, next.b).best(middle(next.a, next.b));
      if (keeps_topology(next) && keeps_facing(next, place)) apply(next, place);
    }
    return result();
  }

  // The same in rounds over all points. In each round every point collapses its cheapest edge if the round's
  // reach allows it; the reach grows from round to round. The order is roughly that of a heap, in a fraction
  // of the time, since neighbouring points are close in memory.
  Fewer run_in_rounds() {
    const double furthest = reach_;
    for (const double share : {0.125, 0.25, 0.5, 1.0, 1.0}) {
      reach_ = share * furthest;
      for (std::uint32_t v = 0; v < points_.size(); ++v) collapse_cheapest(v);
    }
    return result();
  }

 private:
  std::pair<Vector3d, double> plane(const Triangle& t) const {
    const Vector3d twice = (points_[t[1]] - points_[t[0]]).cross(points_[t[2]] - points_[t[0]]);
    const double length = twice.norm();
    return {length > 0 ? Vector3d(twice / length) : Vector3d::Zero(), length / 2};
  }

  void collapse_cheapest(std::uint32_t v) {
    if (gone(v) || locked_[v]) return;
    find_neighbours(v, ring_);
    std::optional<Collapse> cheapest;
    for (const std::uint32_t w : ring_) {
      if (w < v) continue;  // handled from w
      const auto one = collapse_of(v, w);
      if (one && (!cheapest || one->cost < cheapest->cost)) cheapest = one;
    }
    if (!cheapest) return;
    const Vector3d place = joined(v, cheapest->b).best(middle(v, cheapest->b));
    if (keeps_topology(*cheapest) && keeps_facing(*cheapest, place)) merge(*cheapest, place);
  }

  bool gone(std::uint32_t v) const { return triangles_of_[v].empty(); }

  std::optional<Collapse> collapse_of(std::uint32_t a, std::uint32_t b) const {
    if (locked_[a] || locked_[b]) return {};
    const Quadric sum = joined(a, b);
    if (!(sum.weight > 0)) return {};
    const double cost = sum.error(sum.best(middle(a, b)));
    if (cost > reach_ * reach_ * sum.weight) return {};  // the planes' mean squared distance
    return Collapse{cost, a, b, stamps_[a] + stamps_[b]};
  }
  void consider(std::uint32_t a, std::uint32_t b) {
    if (const auto one = collapse_of(a, b)) queue_.push(*one);
  }

  Quadric joined(std::uint32_t a, std::uint32_t b) const {
    Quadric sum = quadrics_[a];
    sum += quadrics_[b];
    return sum;
  }
  Vector3d middle(std::uint32_t a, std::uint32_t b) const { return (points_[a] + points_[b]) / 2; }

  // The points that share a triangle with v, once each. Afterwards marks_ equals mark_ at these points until
  // the next call.
  void find_neighbours(std::uint32_t v, std::vector<std::uint32_t>& ring) {
    ring.clear();
    ++mark_;
    for (const std::uint32_t t : triangles_of_[v])
      for (const std::uint32_t w : triangles_[t])
        if (w != v && std::exchange(marks_[w], mark_) != mark_) ring.push_back(w);
  }

  // Link condition: the ends' common neighbours are exactly the two across the edge, and the remainder is
  // more than a tetrahedron.
  bool keeps_topology(const Collapse& c) {
    find_neighbours(c.b, other_ring_);
    const std::uint32_t of_b = mark_;
    std::size_t around_a = 0, common = 0;
    ++mark_;
    for (const std::uint32_t t : triangles_of_[c.a])
      for (const std::uint32_t w : triangles_[t]) {
        if (w == c.a) continue;
        const std::uint32_t before = std::exchange(marks_[w], mark_);
        around_a += before != mark_;
        common += before == of_b;
      }
    return common == 2 && around_a + other_ring_.size() > 6;
  }

  // whether the collapse is harmless to the triangles that stay: none turns by more than about 75 degrees,
  // becomes a needle, or gets an edge that is too long
  bool keeps_facing(const Collapse& c, const Vector3d& place) const {
    for (const auto& [moved, other] : {std::pair(c.a, c.b), std::pair(c.b, c.a)}) {
      for (const std::uint32_t t : triangles_of_[moved]) {
        const Triangle& corners = triangles_[t];
        if (std::ranges::find(corners, other) != corners.end()) continue;
        std::array<Vector3d, 3> p;
        for (std::size_t i = 0; i < 3; ++i) p[i] = corners[i] == moved ? place : points_[corners[i]];
        const Vector3d twice = (p[1] - p[0]).cross(p[2] - p[0]);
        const double longest =
            std::max({(p[1] - p[0]).squaredNorm(), (p[2] - p[1]).squaredNorm(), (p[0] - p[2]).squaredNorm()});
        const auto [before, area] = plane(corners);
        if (longest > longest_edge_ * longest_edge_) return false;
        if (twice.norm() < 0.02 * longest || (area > 0 && twice.dot(before) < 0.25 * twice.norm()))
          return false;
      }
    }
    return true;
  }

  void apply(const Collapse& c, const Vector3d& place) {
    merge(c, place);
    find_neighbours(c.a, ring_);
    for (const std::uint32_t v : ring_) consider(c.a, v);
  }

  void merge(const Collapse& c, const Vector3d& place) {
    for (const std::uint32_t t : triangles_of_[c.b]) {
      Triangle& corners = triangles_[t];
      if (std::ranges::find(corners, c.a) != corners.end()) {  // one of the two at the edge: removed
        for (const std::uint32_t v : corners)
          if (v != c.b) std::erase(triangles_of_[v], t);
        corners = {0, 0, 0};
        continue;
      }
      std::ranges::replace(corners, c.b, c.a);
      triangles_of_[c.a].push_back(t);
    }
    triangles_of_[c.b].clear();
    into_[c.b] = c.a;
    points_[c.a] = place;
    quadrics_[c.a] += quadrics_[c.b];
    ++stamps_[c.a];
  }

  Fewer result() const {
    Fewer out;
    std::vector<std::uint32_t> number(points_.size());
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (gone(v)) continue;
      number[v] = static_cast<std::uint32_t>(out.surface.points.size());
      out.surface.points.push_back(points_[v] + near_);
    }
    for (const Triangle& t : triangles_)
      if (t[0] != t[1]) out.surface.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      std::uint32_t last = v;
      while (into_[last] != last) last = into_[last];
      out.home.push_back(number[last]);
    }
    return out;
  }

  Vector3d near_;
  double reach_, longest_edge_;
  const std::vector<bool>& locked_;
  std::vector<Vector3d> points_;
  std::vector<Triangle> triangles_;
  std::vector<std::vector<std::uint32_t>> triangles_of_;  // by point; empty if the point was removed
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> stamps_;
  std::vector<std::uint32_t> into_;  // target of each point's collapse; itself if it remains
  std::priority_queue<Collapse> queue_;
  std::vector<std::uint32_t> ring_, other_ring_, marks_;  // scratch
  std::uint32_t mark_ = 0;
};

// Ericson (2005) "Real-Time Collision Detection", 5.1.5: by the region of the triangle's plane that contains
// p's projection
double squared_distance(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
  if (va <= 0 && d4 >= d3 && d5 >= d6)
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).squaredNorm();
  const double sum = va + vb + vc;
  return sum > 0 ? (ap - vb / sum * ab - vc / sum * ac).squaredNorm()
                 : std::min({ap.squaredNorm(), bp.squaredNorm(), cp.squaredNorm()});
}

/// Finds points near a surface with fewer triangles.
class Nearby {
 public:
  Nearby(const TriangleSurface& fewer, double tolerance)
      : fewer_(fewer),
        squared_(tolerance * tolerance),
        around_(fewer.points.size()),
        seen_(fewer.points.size(), 0) {
    for (std::uint32_t t = 0; t < fewer.triangles.size(); ++t)
      for (const std::uint32_t v : fewer.triangles[t]) around_[v].push_back(t);
  }

  // Whether p is within the tolerance of a triangle at most `rings` triangles away from point `home`.
  bool within(const Vector3d& p, std::uint32_t home, int rings) {
    if (near_one(p, home)) return true;
    seen_[home] = ++search_;
    ring_.assign(1, home);
    for (int r = 1; r < rings; ++r) {
      next_.clear();
      for (const std::uint32_t v : ring_)
        for (const std::uint32_t t : around_[v])
          for (const std::uint32_t w : fewer_.triangles[t])
            if (std::exchange(seen_[w], search_) != search_) next_.push_back(w);
      if (std::ranges::any_of(next_, [&](std::uint32_t v) { return near_one(p, v); })) return true;
      ring_.swap(next_);
    }
    return false;
  }

 private:
  bool near(const Vector3d& p, std::uint32_t t) const {
    const Triangle& c = fewer_.triangles[t];
    return squared_distance(p, fewer_.points[c[0]], fewer_.points[c[1]], fewer_.points[c[2]]) <= squared_;
  }
  bool near_one(const Vector3d& p, std::uint32_t v) {
    if (last_ < fewer_.triangles.size() && std::ranges::count(fewer_.triangles[last_], v) > 0 &&
        near(p, last_))
      return true;
    const auto found = std::ranges::find_if(around_[v], [&](std::uint32_t t) { return near(p, t); });
    if (found != around_[v].end()) last_ = *found;
    return found != around_[v].end();
  }

  const TriangleSurface& fewer_;
  double squared_;                                  // squared tolerance
  std::vector<std::vector<std::uint32_t>> around_;  // triangles of a point
  std::uint32_t last_ = 0;  // the triangle near the previous point: often near the next one too
  std::vector<std::uint32_t> seen_, ring_, next_;  // scratch; seen_: number of the last search at a point
  std::uint32_t search_ = 0;
};

// Points of `surface` that may lie farther than `tolerance` from `fewer`; `home` gives each point's point on
// `fewer`. The nearest triangle is searched around the home: a point that passes is near enough, and few near
// ones are rejected.
std::vector<std::uint32_t> too_far(const TriangleSurface& surface, const TriangleSurface& fewer,
                                   const std::vector<std::uint32_t>& home, double tolerance) {
  Nearby nearby(fewer, tolerance);
  std::vector<std::uint32_t> far;
  for (std::uint32_t n = 0; n < surface.points.size(); ++n)
    if (!nearby.within(surface.points[n], home[n], 2)) far.push_back(n);
  // Points of a fine surface may have moved further along it; search wider. If there are many, most are
  // really far.
  if (far.size() <= surface.points.size() / 1000)
    std::erase_if(far, [&](std::uint32_t n) { return nearby.within(surface.points[n], home[n], 6); });
  return far;
}

std::vector<std::uint32_t> composed(const std::vector<std::uint32_t>& first,
                                    const std::vector<std::uint32_t>& then) {
  std::vector<std::uint32_t> out;
  out.reserve(first.size());
  for (const std::uint32_t v : first) out.push_back(then[v]);
  return out;
}

// One step: simplifies `start` while each point of `surface` stays within `tolerance`, and updates the homes
// of its points. If a point would be too far, the points of `start` around its home are locked and the step
// is repeated. Empty if that does not help.
std::optional<Fewer> step_down(const TriangleSurface& surface, const Fewer& start, double reach,
                               double tolerance, double longest_edge, bool in_rounds = false) {
  std::vector<bool> locked(start.surface.points.size(), false);
  for (int attempt = 0; attempt < 10; ++attempt) {
    Decimation decimation(start.surface, reach, longest_edge, locked);
    Fewer fewer = in_rounds ? decimation.run_in_rounds() : decimation.run();
    fewer.home = composed(start.home, fewer.home);
    const auto far = too_far(surface, fewer.surface, fewer.home, tolerance);
    if (far.empty()) return fewer;
    for (const std::uint32_t n : far) locked[start.home[n]] = true;
    const auto found = locked;
    for (const Triangle& t : start.surface.triangles)  // and their neighbours
      if (found[t[0]] || found[t[1]] || found[t[2]]) locked[t[0]] = locked[t[1]] = locked[t[2]] = true;
  }
  return std::nullopt;
}

}  // namespace

TriangleSurface decimate(const TriangleSurface& surface, double tolerance, double longest_edge) {
  if (surface.triangles.empty() || !(tolerance > 0)) return surface;
  Fewer best{surface, std::vector<std::uint32_t>(surface.points.size())};
  std::iota(best.home.begin(), best.home.end(), 0u);
  constexpr double first_reach = 0.05;  // over the tolerance
  if (auto fewer = step_down(surface, best, first_reach * tolerance, tolerance, longest_edge, true))
    best = std::move(*fewer);
  // A collapse knows only its mean distance from planes, not the farthest point's. So the reach grows in
  // steps, each measured. The first step does most of the work.
  for (double reach = 0.15 * tolerance; reach < 0.9 * tolerance; reach *= 1.6) {
    auto fewer = step_down(surface, best, reach, tolerance, longest_edge);
    if (!fewer) break;
    best = std::move(*fewer);
  }
  return best.surface;
}

bool is_closed(std::size_t points, const std::vector<Triangle>& triangles) {
  std::vector<std::uint64_t> passes;  // directed edges: start * points + end
  passes.reserve(triangles.size() * 3);
  for (const Triangle& t : triangles)
    for (std::size_t e = 0; e < 3; ++e)
      passes.push_back(t[e] * static_cast<std::uint64_t>(points) + t[(e + 1) % 3]);
  std::ranges::sort(passes);
  if (std::ranges::adjacent_find(passes) != passes.end()) return false;  // twice in the same direction
  for (const std::uint64_t edge : passes) {
    const std::uint64_t from = edge / points, to = edge % points;
    if (from == to || !std::ranges::binary_search(passes, to * points + from)) return false;
  }
  return !triangles.empty();
}

}  // namespace borelli
