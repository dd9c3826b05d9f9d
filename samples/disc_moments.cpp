#include "samples/disc_moments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace borelli {
namespace {

using Eigen::Vector2d;
constexpr double pi = std::numbers::pi;

// The integrands of Green's theorem along the unit circle, integrated from angle 0 to `angle`:
// cos^2, cos^3/2, cos^2 sin, cos^4/3, cos^2 sin^2, cos^3 sin / 2.
PlaneMoments arc_antiderivative(double angle) {
  const double s = std::sin(angle), c = std::cos(angle), s2 = 2 * s * c, s4 = 2 * s2 * (c * c - s * s);
  PlaneMoments m;
  m << angle / 2 + s2 / 4, (s - s * s * s / 3) / 2, -c * c * c / 3, (3 * angle / 8 + s2 / 4 + s4 / 32) / 3,
      angle / 8 - s4 / 32, -c * c * c * c / 8;
  return m;
}

// The same integrals, of x^(p+1)/(p+1) y^q dy, along the straight line from p to q. The integrands are at
// most cubic, so two Gauss points are exact.
PlaneMoments chord_integral(const Vector2d& p, const Vector2d& q) {
  constexpr double node = 0.57735026918962576451;  // 1/sqrt(3)
  PlaneMoments m = PlaneMoments::Zero();
  for (const double t : {-node, node}) {
    const Vector2d u = 0.5 * (p + q) + 0.5 * t * (q - p);
    const double x = u.x(), y = u.y();
    PlaneMoments term;
    term << x, x * x / 2, x * y, x * x * x / 3, x * y * y, x * x * y / 2;
    m += term;
  }
  return m * (0.5 * (q.y() - p.y()));
}

// The arcs of the circle that remain: each cut removes the angles within acos(offset) of its normal.
PlaneMoments arcs(std::span<const HalfPlane> cuts) {
  std::array<std::pair<double, double>, 2 * most_cuts> taken;
  std::size_t count = 0;
  for (const HalfPlane& cut : cuts) {
    const double half = std::acos(cut.offset);
    double from = std::atan2(cut.normal.y(), cut.normal.x()) - half;
    if (from < -pi) from += 2 * pi;
    const double to = from + 2 * half;
    if (to > pi) {
      taken[count++] = {from, pi};
      taken[count++] = {-pi, to - 2 * pi};
    } else {
      taken[count++] = {from, to};
    }
  }
  std::sort(taken.begin(), taken.begin() + static_cast<std::ptrdiff_t>(count));
  PlaneMoments m = PlaneMoments::Zero();
  double at = -pi;
  for (std::size_t i = 0; i < count; ++i) {
    if (taken[i].first > at) m += arc_antiderivative(taken[i].first) - arc_antiderivative(at);
    at = std::max(at, taken[i].second);
  }
  if (at < pi) m += arc_antiderivative(pi) - arc_antiderivative(at);
  return m;
}

}  // namespace

PlaneMoments disc_moments(std::span<const HalfPlane> given) {
  std::array<HalfPlane, most_cuts> kept;
  std::size_t count = 0;
  for (const HalfPlane& cut : given) {
    if (cut.offset <= -1) return PlaneMoments::Zero();
    if (cut.offset >= 1) continue;
    // of two cuts with one normal only the tighter counts; otherwise both chords would be summed
    const auto same = std::find_if(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(count),
                                   [&](const HalfPlane& k) { return k.normal == cut.normal; });
    if (same != kept.begin() + static_cast<std::ptrdiff_t>(count))
      same->offset = std::min(same->offset, cut.offset);
    else
      kept[count++] = cut;
  }
  const std::span<const HalfPlane> cuts(kept.data(), count);

  PlaneMoments m = arcs(cuts);
  for (std::size_t i = 0; i < count; ++i) {
    // the chord of cut i, traversed with the region on its left and clipped by the other cuts
    const Vector2d n = cuts[i].normal, along(-n.y(), n.x());
    const double half = std::sqrt(1 - cuts[i].offset * cuts[i].offset);
    double from = -half, to = half;
    for (std::size_t j = 0; j < count; ++j) {
      if (j == i) continue;
      const double slope = cuts[j].normal.dot(along),
                   room = cuts[j].offset - cuts[j].normal.dot(n) * cuts[i].offset;
      if (slope > 0)
        to = std::min(to, room / slope);
      else if (slope < 0)
        from = std::max(from, room / slope);
      else if (room < 0)
        to = from;
    }
    if (to > from) m += chord_integral(cuts[i].offset * n + from * along, cuts[i].offset * n + to * along);
  }
  return m;
}

}  // namespace borelli
