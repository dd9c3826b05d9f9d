// The rows of one contact between two solids, for the kinds of contact between forms: a sphere (or point)
// over a plane, and two capsules (or spheres). For constraint kinds' `evaluate`.
#pragma once

#include <Eigen/Geometry>

#include "dynamics/contact.hpp"
#include "dynamics/site.hpp"

namespace borelli {

template <class T>
class ConstraintScan;

/// A unit vector across n: that of x, or of y where n lies along x.
template <class T>
Eigen::Vector3<T> across(const Eigen::Vector3<T>& n) {
  using std::sqrt;
  const Eigen::Vector3<T> e = std::abs(value_of(n[0])) < 0.9 ? Eigen::Vector3<T>(T(1), T(0), T(0))
                                                             : Eigen::Vector3<T>(T(0), T(1), T(0));
  const Eigen::Vector3<T> t = e - n.dot(e) * n;
  return t / sqrt(t.squaredNorm());
}

/// Row r: the velocity along t of solid a over solid b where they touch, at p, which moves with `p_rate` over
/// both. The second derivative of what it slips holds, beside the accelerations of the solids' own points
/// there, that the point of contact wanders over them.
template <class T>
void slip_row(ConstraintScan<T>& scan, int r, int a, int b, const Eigen::Vector3<T>& p,
              const Eigen::Vector3<T>& p_rate, const Eigen::Vector3<T>& t, const Eigen::Vector3<T>& t_rate) {
  const Eigen::Vector3<T> va = scan.velocity(a, p), vb = scan.velocity(b, p);
  scan.along(r, a, p, t);
  scan.along(r, b, p, -t);
  scan.residual(
      r, T(0), T(0),
      t.dot(scan.angular_velocity(a).cross(p_rate - va) - scan.angular_velocity(b).cross(p_rate - vb)) +
          t_rate.dot(va - vb));
}

/// Rows r, r + 1, r + 2: a sphere of solid a, `centre` and `radius`, over the plane of solid b through `on`
/// with the unit normal `normal`, both in b's frame: n . (c - on) - radius >= 0. See PointOnPlane.
template <class T>
void sphere_over_plane(ConstraintScan<T>& scan, int r, int a, const Eigen::Vector3d& centre, double radius,
                       int b, const Eigen::Vector3d& on, const Eigen::Vector3d& normal) {
  const auto c = scan.point(a, centre);
  const auto X = scan.frame(b);
  const Eigen::Vector3<T> n = X.R * normal, w = scan.angular_velocity(b);
  const Eigen::Vector3<T> v_rel = c.v - scan.velocity(b, c.p);
  scan.along(r, a, c.p, n);
  scan.along(r, b, c.p, -n);
  scan.residual(r, n.dot(c.p - scan.point(b, on).p) - radius, T(0), -2 * n.dot(w.cross(v_rel)));
  const Eigen::Vector3<T> p = c.p - radius * n, p_rate = c.v - radius * w.cross(n);
  const Eigen::Vector3d t_B = across<double>(normal), s_B = normal.cross(t_B);
  const Eigen::Vector3<T> t = X.R * t_B, s = X.R * s_B;
  slip_row<T>(scan, r + 1, a, b, p, p_rate, t, w.cross(t));
  slip_row<T>(scan, r + 2, a, b, p, p_rate, s, w.cross(s));
}

/// A segment with a thickness: a capsule; of length 0 a sphere.
struct ThickSegment {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit
  double length = 0, radius = 0;                    ///< m, without the caps
};

/// Rows r, r + 1, r + 2: two capsules keep off each other. The distance of two segments is the least over the
/// points s, t of both; its second derivative takes in that the nearest points move along (c^T K^-1 c, with K
/// the second derivatives of |d|^2 / 2 by s and t, and c its mixed ones by them and time).
template <class T>
void capsule_over_capsule(ConstraintScan<T>& scan, int r, int a, const ThickSegment& A, int b,
                          const ThickSegment& B) {
  using std::sqrt;
  using Vector = Eigen::Vector3<T>;
  const auto ca = scan.point(a, A.centre), cb = scan.point(b, B.centre);
  const Vector ua = scan.frame(a).R * A.axis, ub = scan.frame(b).R * B.axis;
  const Vector wa = scan.angular_velocity(a), wb = scan.angular_velocity(b), between = ca.p - cb.p;
  const T cosine = ua.dot(ub), da = ua.dot(between), db = ub.dot(between), K = 1 - cosine * cosine;
  const auto clamped = [](const T& x, double half, bool& free) {
    free = std::abs(value_of(x)) < half;
    return free ? x : T(value_of(x) < 0 ? -half : half);
  };
  const double ha = A.length / 2, hb = B.length / 2;
  // of parallel ones no pair of points is nearest: that at a's middle is taken
  const bool parallel = value_of(K) < 1e-12;
  bool free_a = false, free_b = false;
  T s = parallel ? T(0) : clamped((cosine * db - da) / K, ha, free_a);
  const T t = clamped(cosine * s + db, hb, free_b);
  if (!free_b) s = clamped(cosine * t - da, ha, free_a);
  const Vector xa = ca.p + s * ua, xb = cb.p + t * ub, d = xa - xb;
  const T length = sqrt(d.squaredNorm());
  if (!(value_of(length) > 1e-12 * (A.radius + B.radius))) {
    scan.degenerate(r);
    return;
  }
  const Vector n = d / length;
  const Vector va = ca.v + s * wa.cross(ua), vb = cb.v + t * wb.cross(ub), v = va - vb;
  const T mixed_a = ua.dot(v) + d.dot(wa.cross(ua)), mixed_b = -ub.dot(v) - d.dot(wb.cross(ub));
  T s_rate(0), t_rate(0);
  if (free_a && free_b && !parallel) {
    s_rate = -(mixed_a + cosine * mixed_b) / K;
    t_rate = -(cosine * mixed_a + mixed_b) / K;
  } else if (free_b) {
    t_rate = -mixed_b;
  } else if (free_a) {
    s_rate = -mixed_a;
  }
  const T opening = n.dot(v);
  scan.along(r, a, xa, n);
  scan.along(r, b, xb, -n);
  scan.residual(r, length - A.radius - B.radius, T(0),
                (v.squaredNorm() + mixed_a * s_rate + mixed_b * t_rate - opening * opening) / length);
  const Vector xb_rate = vb + t_rate * ub, d_rate = va + s_rate * ua - xb_rate;
  const Vector n_rate = (d_rate - n.dot(d_rate) * n) / length;
  const Vector p = xb + B.radius * n, p_rate = xb_rate + B.radius * n_rate;
  const Vector e = across<T>(n), none = Vector::Zero();
  // axes across are chosen anew at each place: how they turn matters to a slip alone, which they only measure
  slip_row<T>(scan, r + 1, a, b, p, p_rate, e, none);
  slip_row<T>(scan, r + 2, a, b, p, p_rate, n.cross(e), none);
}

}  // namespace borelli
