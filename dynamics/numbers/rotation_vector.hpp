// Rotation vectors (axis times angle) and quaternions: exponential map, logarithm, and the relation between
// the rate of a rotation vector and the body angular velocity. Closed forms, with series near zero; see
// Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods, Acta Numerica 2000, appendix B.
#pragma once

#include <array>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// The unit quaternion of the rotation vector theta (rad).
template <class V>
QuaternionOf<typename V::Scalar> exponential(const Eigen::MatrixBase<V>& vector) {
  using T = typename V::Scalar;
  using Q = QuaternionOf<T>;
  using std::cos, std::sin, std::sqrt;
  const Eigen::Vector3<T> theta = vector;
  const T angle2 = theta.squaredNorm();
  return either(
      angle2 < 1e-6,
      [&] {  // sin(angle/2)/angle and cos(angle/2); the series' next terms are below rounding here
        const T s = 0.5 - angle2 / 48 + angle2 * angle2 / 3840;
        return Q(1 - angle2 / 8 + angle2 * angle2 / 384, s * theta[0], s * theta[1], s * theta[2]);
      },
      [&] {
        const T angle = sqrt(angle2), s = sin(angle / 2) / angle;
        return Q(cos(angle / 2), s * theta[0], s * theta[1], s * theta[2]);
      });
}

/// The rotation vector of a unit quaternion, its length at most pi (rad).
template <class A>
Eigen::Vector3<typename A::Scalar> logarithm(const Eigen::MatrixBase<A>& a) {
  using T = typename A::Scalar;
  using std::atan2, std::sqrt;
  const T sign = either(
      a[0] < 0, [] { return T(-1); }, [] { return T(1); });
  const Eigen::Vector3<T> vector = sign * a.template tail<3>();
  const T s2 = vector.squaredNorm(), w = sign * a[0];
  const T factor = either(
      s2 < 1e-12, [&] { return T(2 / w * (1 - s2 / (3 * w * w))); },
      [&] {
        const T s = sqrt(s2);
        return T(2 * atan2(s, w) / s);
      });
  return factor * vector;
}

/// The rate of theta for a body angular velocity w, where R = R0 exp(theta): the inverse of the right
/// Jacobian, w + theta x w / 2 + c theta x (theta x w), c = 1/angle^2 - cot(angle/2) / (2 angle). Singular at
/// angle = 2 pi.
template <class V, class W>
Eigen::Vector3<typename V::Scalar> rotation_vector_rate(const Eigen::MatrixBase<V>& vector,
                                                        const Eigen::MatrixBase<W>& w) {
  using T = typename V::Scalar;
  using std::cos, std::sin, std::sqrt;
  const Eigen::Vector3<T> theta = vector;
  const T angle2 = theta.squaredNorm();
  const T c = either(
      angle2 < 1e-4, [&] { return T(1.0 / 12 + angle2 / 720 + angle2 * angle2 / 30240); },
      [&] {
        const T angle = sqrt(angle2);
        return T(1 / angle2 - cos(angle / 2) / (2 * angle * sin(angle / 2)));
      });
  const Eigen::Vector3<T> cross = theta.cross(w);
  return w + 0.5 * cross + c * theta.cross(cross);
}

/// Body angular velocity (rad/s) and acceleration (rad/s^2) of R = R0 exp(theta(t)), from theta (rad) and its
/// first two derivatives.
inline std::array<Eigen::Vector3d, 2> body_velocity(const Eigen::Vector3d& theta, const Eigen::Vector3d& rate,
                                                    const Eigen::Vector3d& acceleration) {
  // w = rate - a theta x rate + b theta x (theta x rate), a = (1 - cos)/angle^2, b = (angle - sin)/angle^3;
  // da and db are the derivatives of a and b by angle, divided by angle
  const double x = theta.squaredNorm(), angle = std::sqrt(x);
  double a, b, da, db;
  if (angle < 0.05) {  // the first terms left out are below 1e-15 here
    a = 0.5 - x / 24 + x * x / 720 - x * x * x / 40320;
    b = 1.0 / 6 - x / 120 + x * x / 5040 - x * x * x / 362880;
    da = -1.0 / 12 + x / 180 - x * x / 6720 + x * x * x / 453600;
    db = -1.0 / 60 + x / 1260 - x * x / 60480 + x * x * x / 4989600;
  } else {
    const double s = std::sin(angle), c = std::cos(angle);
    a = (1 - c) / x;
    b = (angle - s) / (x * angle);
    da = (angle * s - 2 * (1 - c)) / (x * x);
    db = (angle * (1 - c) - 3 * (angle - s)) / (x * x * angle);
  }
  const double stretch = theta.dot(rate);  // angle times its rate
  const Eigen::Vector3d u = theta.cross(rate), uu = theta.cross(u);
  const Eigen::Vector3d n = theta.cross(acceleration);
  return {Eigen::Vector3d(rate - a * u + b * uu),
          Eigen::Vector3d(acceleration - da * stretch * u - a * n + db * stretch * uu +
                          b * (rate.cross(u) + theta.cross(n)))};
}

}  // namespace borelli
