// Holonomic constraint: two points keep a distance (a massless rod), which may be a function of time.
#pragma once

#include <string_view>

#include "dynamics/numbers/scalar.hpp"
#include "dynamics/numbers/time_function.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// Row 0: `sign` times (distance of the two points - asked.value), m. Where the points coincide the row has
/// no direction. It then gets its value only, and the function returns false.
template <class T>
bool distance_row(ConstraintPass<T>& pass, const SolidPoint& a, const SolidPoint& b, const TimeValue& asked,
                  double sign) {
  enum { a_site, b_site };
  const auto pa = pass.point(a_site, a.point), pb = pass.point(b_site, b.point);
  const Eigen::Vector3<T> d = pa.p - pb.p, v = pa.v - pb.v;
  using std::sqrt;
  const T length = sqrt(d.squaredNorm()), off = sign * (length - asked.value);
  const bool apart = value_of(length) > 1e-12 * std::abs(asked.value);
  if (!apart) {
    pass.residual(0, off, T(0), T(0));
    return false;
  }
  const Eigen::Vector3<T> n = d / length, towards = sign * n;
  pass.along(0, a_site, pa.p, towards);
  pass.along(0, b_site, pb.p, -towards);
  const T across = v.squaredNorm() - n.dot(v) * n.dot(v);
  pass.residual(0, off, T(-sign * asked.rate), sign * (across / length - asked.acceleration));
  return true;
}

/// |p_a - p_b| - distance(t) = 0: one row, m. The distance must stay positive: at zero the rod has no
/// direction.
struct Distance {
  static constexpr std::string_view kind = "distance";
  SolidPoint a, b;
  TimeFunction distance = constant(1);  ///< m

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("distance", self.distance);
  }

  std::string complaint() const {
    return at(distance, 0).value > 0 ? "" : "its distance must be positive at the start";
  }

  static constexpr int rows = 1;
  static constexpr int length_rows = 1;  ///< number of leading rows in m

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    if (!distance_row(pass, a, b, at(distance, pass.time()), 1)) pass.degenerate(0);
  }
};

}  // namespace borelli
