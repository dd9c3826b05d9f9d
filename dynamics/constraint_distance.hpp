// Holonomic constraint: two points keep a distance (a massless rod), which may be a function of time.
#pragma once

#include <string_view>

#include "dynamics/site.hpp"
#include "dynamics/time_function.hpp"

namespace borelli {

template <class T>
class ConstraintScan;

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
  static constexpr int length_rows = 1;  ///< the first ones, which are in m

  template <class T>
  void evaluate(ConstraintScan<T>& scan) const {
    enum { a_site, b_site };
    const auto pa = scan.point(a_site, a.point), pb = scan.point(b_site, b.point);
    const Eigen::Vector3<T> d = pa.p - pb.p, v = pa.v - pb.v;
    using std::sqrt;
    const T length = sqrt(d.squaredNorm());
    const TimeValue asked = at(distance, scan.time());
    if (!(length > 1e-12 * std::abs(asked.value)) || length == 0) {
      scan.degenerate(0);
      scan.residual(0, length - asked.value, 0, 0);
      return;
    }
    const Eigen::Vector3<T> n = d / length;
    scan.along(0, a_site, pa.p, n);
    scan.along(0, b_site, pb.p, -n);
    const T across = v.squaredNorm() - n.dot(v) * n.dot(v);
    scan.residual(0, length - asked.value, -asked.rate, across / length - asked.acceleration);
  }
};

}  // namespace borelli
