// Unilateral constraint: two points come no farther from each other than a rope between them is long.
#pragma once

#include <cmath>
#include <string_view>

#include "dynamics/contact.hpp"
#include "dynamics/site.hpp"

namespace borelli {

template <class T>
class ConstraintScan;

/// length - |p_a - p_b| >= 0: one contact without friction, m.
struct Rope {
  static constexpr std::string_view kind = "rope";
  SolidPoint a, b;
  double length = 1;  ///< m
  double restitution = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("length", self.length);
    visit("restitution", self.restitution);
  }

  std::string complaint() const {
    return length > 0 ? ContactSurface{.restitution = restitution}.complaint()
                      : "its length must be positive";
  }

  static constexpr int rows = 1;
  static constexpr int length_rows = 1;
  static constexpr int contact_rows = 1;

  template <class T>
  void evaluate(ConstraintScan<T>& scan) const {
    enum { a_site, b_site };
    const auto pa = scan.point(a_site, a.point), pb = scan.point(b_site, b.point);
    const Eigen::Vector3<T> d = pa.p - pb.p, v = pa.v - pb.v;
    using std::sqrt;
    const T distance = sqrt(d.squaredNorm());
    if (!(value_of(distance) > 1e-12 * length)) {  // slack, and without a direction
      scan.residual(0, T(length), T(0), T(0));
      return;
    }
    const Eigen::Vector3<T> n = d / distance;
    scan.along(0, a_site, pa.p, -n);
    scan.along(0, b_site, pb.p, n);
    const T opening = n.dot(v);
    scan.residual(0, length - distance, T(0), -(v.squaredNorm() - opening * opening) / distance);
  }
};

}  // namespace borelli
