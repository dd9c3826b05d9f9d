// Rotation vectors (axis times angle) and quaternions: the exponential map, its inverse, and how a rotation
// vector's rate goes with the body angular velocity. Closed forms with series near zero; see Iserles,
// Munthe-Kaas, Norsett, Zanna, Lie-group methods, Acta Numerica 2000, appendix B.
#pragma once

#include <array>

#include "dynamics/pose.hpp"

namespace borelli {

/// The unit quaternion of the rotation vector theta (rad).
inline Quaternion exponential(const Eigen::Vector3d& theta) {
  const double angle2 = theta.squaredNorm(), angle = std::sqrt(angle2);
  // sin(angle/2)/angle; the series' next term is below rounding here
  const double s = angle < 1e-3 ? 0.5 - angle2 / 48 + angle2 * angle2 / 3840 : std::sin(angle / 2) / angle;
  return {std::cos(angle / 2), s * theta[0], s * theta[1], s * theta[2]};
}

/// The rotation vector of a unit quaternion, its length at most pi (rad).
inline Eigen::Vector3d logarithm(const Quaternion& a) {
  const double sign = a[0] < 0 ? -1 : 1;
  const Eigen::Vector3d vector = sign * a.tail<3>();
  const double s = vector.norm(), w = sign * a[0];
  const double factor = s < 1e-6 ? 2 / w * (1 - s * s / (3 * w * w)) : 2 * std::atan2(s, w) / s;
  return factor * vector;
}

/// The rate of theta for a body angular velocity w, where R = R0 exp(theta): the inverse of the right
/// Jacobian, w + theta x w / 2 + c theta x (theta x w), c = 1/angle^2 - cot(angle/2) / (2 angle). Breaks down
/// at angle = 2 pi.
inline Eigen::Vector3d rotation_vector_rate(const Eigen::Vector3d& theta, const Eigen::Vector3d& w) {
  const double angle2 = theta.squaredNorm();
  double c;
  if (angle2 < 1e-4) {
    c = 1.0 / 12 + angle2 / 720 + angle2 * angle2 / 30240;
  } else {
    const double angle = std::sqrt(angle2);
    c = 1 / angle2 - std::cos(angle / 2) / (2 * angle * std::sin(angle / 2));
  }
  const Eigen::Vector3d cross = theta.cross(w);
  return w + 0.5 * cross + c * theta.cross(cross);
}

/// Body angular velocity and acceleration of R = R0 exp(theta(t)), from theta and its two derivatives.
inline std::array<Eigen::Vector3d, 2> body_velocity(const Eigen::Vector3d& theta, const Eigen::Vector3d& rate,
                                                    const Eigen::Vector3d& acceleration) {
  // w = rate - a theta x rate + b theta x (theta x rate), a = (1 - cos)/angle^2, b = (angle - sin)/angle^3;
  // da and db are the derivatives of a and b by angle, over angle
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
