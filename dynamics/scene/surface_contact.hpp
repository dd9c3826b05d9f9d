// The rows of a contact between two solids, for `evaluate` of constraint kinds: unilateral (sphere or point
// over a plane, two capsules or spheres) and rolling.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <type_traits>

#include "dynamics/scene/contact.hpp"
#include "dynamics/scene/plane.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// A unit vector normal to the unit vector n: the projection of x, or of y if n lies along x.
template <class T>
Eigen::Vector3<T> across(const Eigen::Vector3<T>& n) {
  using std::sqrt;
  const Eigen::Vector3<T> e = std::abs(value_of(n[0])) < 0.9 ? Eigen::Vector3<T>(T(1), T(0), T(0))
                                                             : Eigen::Vector3<T>(T(0), T(1), T(0));
  const Eigen::Vector3<T> t = e - n.dot(e) * n;
  return t / sqrt(t.squaredNorm());
}

/// The contact point of solids a and b, its own velocity `p_rate` (it moves over both), and the gap. World
/// axes, m, m/s.
template <class T>
struct Meeting {
  Eigen::Vector3<T> p, p_rate;
  T gap = T(0);  ///< m
};

/// Rows r to r + N - 1: the velocity of solid a over solid b at the contact point, along the columns of t.
/// Their bias includes that the contact point moves over the solids. `value` is the residual of the first
/// row: its gap, if it has one.
template <class T, int N>
void slip_rows(ConstraintPass<T>& pass, int r, int a, int b, const Meeting<T>& at,
               const Eigen::Matrix<T, 3, N>& t, const Eigen::Matrix<T, 3, N>& t_rate, const T& value = T(0)) {
  if (pass.detail() == ConstraintPass<T>::Detail::values) {
    for (int c = 0; c < N; ++c) pass.residual(r + c, c == 0 ? value : T(0), T(0), T(0));
    return;
  }
  pass.template along_each<N>(r, a, at.p, t);
  pass.template along_each<N>(r, b, at.p, -t);
  if (pass.detail() == ConstraintPass<T>::Detail::rates) {
    for (int c = 0; c < N; ++c) pass.residual(r + c, c == 0 ? value : T(0), T(0), T(0));
    return;
  }
  const Eigen::Vector3<T> va = pass.velocity(a, at.p), vb = pass.velocity(b, at.p), v = va - vb;
  const Eigen::Vector3<T> wanders =
      pass.angular_velocity(a).cross(at.p_rate - va) - pass.angular_velocity(b).cross(at.p_rate - vb);
  for (int c = 0; c < N; ++c)
    pass.residual(r + c, c == 0 ? value : T(0), T(0), t.col(c).dot(wanders) + t_rate.col(c).dot(v));
}

/// A single row of slip_rows().
template <class T>
void slip_row(ConstraintPass<T>& pass, int r, int a, int b, const Meeting<T>& at, const Eigen::Vector3<T>& t,
              const Eigen::Vector3<T>& t_rate, const T& value = T(0)) {
  slip_rows<T, 1>(pass, r, a, b, at, t, t_rate, value);
}

/// Rows r, r + 1, r + 2 of a form of solid a that touches a plane of solid b: the gap, and the velocities
/// along two tangents. Without `held` only the tangential rows, as r and r + 1.
template <class T>
void rows_on_plane(ConstraintPass<T>& pass, int r, int a, const Meeting<T>& at, int b, const Plane& plane,
                   bool held = true) {
  if (pass.detail() == ConstraintPass<T>::Detail::values) {
    if (held) pass.residual(r, at.gap, T(0), T(0));
    return;
  }
  const Eigen::Matrix3<T> R = pass.frame(b).R;
  const Eigen::Vector3<T> w = pass.angular_velocity(b), n = R * plane.normal;
  if (pass.detail() == ConstraintPass<T>::Detail::rates) {
    if (held) slip_row<T>(pass, r, a, b, at, n, w.cross(n), at.gap);
    return;
  }
  const Eigen::Vector3d t_B = across<double>(plane.normal);
  Eigen::Matrix3<T> axes;
  axes << n, R * t_B, R * plane.normal.cross(t_B);
  Eigen::Matrix3<T> rates;
  for (int c = 0; c < 3; ++c) rates.col(c) = w.cross(axes.col(c));
  if (held)
    slip_rows<T, 3>(pass, r, a, b, at, axes, rates, at.gap);
  else
    slip_rows<T, 2>(pass, r, a, b, at, axes.template rightCols<2>(), rates.template rightCols<2>());
}

/// The point of a sphere of solid a nearest to a plane of solid b; the gap is n . (c - on) - radius. Its
/// velocity is computed only for passes with the detail `rows`.
template <class T>
Meeting<T> sphere_on_plane(const ConstraintPass<T>& pass, int a, const Eigen::Vector3d& centre, double radius,
                           int b, const Plane& plane) {
  const auto X = pass.frame(b);
  const Eigen::Vector3<T> c = pass.frame(a) * centre, n = X.R * plane.normal;
  Meeting<T> at{c - radius * n, Eigen::Vector3<T>::Zero(), n.dot(c - X * plane.on.point) - radius};
  if (pass.detail() == ConstraintPass<T>::Detail::rows)
    at.p_rate = pass.velocity(a, c) - radius * pass.angular_velocity(b).cross(n);
  return at;
}

/// Rows r, r + 1, r + 2: a sphere of solid a over a plane of solid b.
template <class T>
void sphere_over_plane(ConstraintPass<T>& pass, int r, int a, const Eigen::Vector3d& centre, double radius,
                       int b, const Plane& plane) {
  rows_on_plane<T>(pass, r, a, sphere_on_plane(pass, a, centre, radius, b, plane), b, plane);
}

/// The radii of two spheres or capsules in contact, m.
struct Radii {
  double a = 0.1, b = 0.1;

  /// In files their fields stand among those of the constraint that contains them.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("radius_a", self.a);
    visit("radius_b", self.b);
  }

  std::string complaint() const {
    return a >= 0 && b >= 0 && a + b > 0 ? ""
                                         : "its radii must be 0 or more, and at least one of them positive";
  }
};

/// A segment with a radius: a capsule, or a sphere if its length is 0.
struct ThickSegment {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit
  double length = 0, radius = 0;                    ///< m; length without the caps
};

/// Rows r, r + 1, r + 2: contact of two capsules. The distance is the minimum over the parameters s, t of the
/// two segments. Its second derivative includes the motion of the nearest points (c^T K^-1 c, with K the
/// second derivatives of |d|^2 / 2 by s and t, and c its mixed ones by them and time).
template <class T>
void capsule_over_capsule(ConstraintPass<T>& pass, int r, int a, const ThickSegment& A, int b,
                          const ThickSegment& B) {
  using std::sqrt;
  using Vector = Eigen::Vector3<T>;
  using Detail = typename ConstraintPass<T>::Detail;
  const auto Xa = pass.frame(a), Xb = pass.frame(b);
  const Vector ca = Xa * A.centre, cb = Xb * B.centre, ua = Xa.R * A.axis, ub = Xb.R * B.axis,
               between = ca - cb;
  const T cosine = ua.dot(ub), da = ua.dot(between), db = ub.dot(between), K = 1 - cosine * cosine;
  const auto clamped = [](const T& x, double half, bool& free) {
    free = std::abs(value_of(x)) < half;
    return free ? x : T(value_of(x) < 0 ? -half : half);
  };
  const double ha = A.length / 2, hb = B.length / 2;
  // parallel segments have no unique nearest points: take those at the middle of a
  const bool parallel = value_of(K) < 1e-12;
  bool free_a = false, free_b = false;
  T s = parallel ? T(0) : clamped((cosine * db - da) / K, ha, free_a);
  const T t = clamped(cosine * s + db, hb, free_b);
  if (!free_b) s = clamped(cosine * t - da, ha, free_a);
  const Vector xa = ca + s * ua, xb = cb + t * ub, d = xa - xb;
  const T length = sqrt(d.squaredNorm()), gap = length - A.radius - B.radius;
  const bool coincide = !(value_of(length) > 1e-12 * (A.radius + B.radius));
  if (coincide) pass.degenerate(r);
  if (pass.detail() == Detail::values) {
    for (int c = 0; c < 3; ++c) pass.residual(r + c, c == 0 ? gap : T(0), T(0), T(0));
    return;
  }
  const Vector wa = pass.angular_velocity(a), wb = pass.angular_velocity(b), va_c = pass.velocity(a, ca),
               vb_c = pass.velocity(b, cb);
  if constexpr (std::is_same_v<T, double>) {
    const Vector closing = va_c - vb_c, turn_a = ha * wa.cross(ua), turn_b = hb * wb.cross(ub);
    double fastest = 0;
    for (const Vector& turn : {Vector(turn_a + turn_b), Vector(turn_a - turn_b)})
      fastest = std::max({fastest, (closing + turn).squaredNorm(), (closing - turn).squaredNorm()});
    pass.speed(r, sqrt(fastest));
  }
  if (coincide) {
    pass.residual(r, gap, T(0), T(0));
    return;
  }
  const Vector n = d / length, e = across<T>(n);
  Meeting<T> at{xb + B.radius * n, Vector::Zero()};
  T bias(0);
  if (pass.detail() == Detail::rows) {
    const Vector va = va_c + s * wa.cross(ua), vb = vb_c + t * wb.cross(ub), v = va - vb;
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
    bias = (v.squaredNorm() + mixed_a * s_rate + mixed_b * t_rate - opening * opening) / length;
    const Vector xb_rate = vb + t_rate * ub, d_rate = va + s_rate * ua - xb_rate;
    at.p_rate = xb_rate + B.radius * (d_rate - n.dot(d_rate) * n) / length;
  }
  pass.along(r, a, xa, n);
  pass.along(r, b, xb, -n);
  pass.residual(r, gap, T(0), bias);
  // The tangents are chosen anew at each place, and their rates are taken as zero. The rates would matter
  // only while the contact slips, and then these rows enforce nothing: they only measure the slip.
  Eigen::Matrix<T, 3, 2> tangents;
  tangents << e, n.cross(e);
  slip_rows<T, 2>(pass, r + 1, a, b, at, tangents, Eigen::Matrix<T, 3, 2>::Zero());
}

}  // namespace borelli
