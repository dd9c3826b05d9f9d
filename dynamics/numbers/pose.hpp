// Rigid transforms and unit quaternions in monogram notation: X_AB = (R_AB, p_AB) places frame B in frame A.
// Templates over the scalar type (scalar.hpp); the short names are for double.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

/// X_AB: the pose of frame B in frame A. A point with coordinates p_B in B has R p_B + p in A. Metres.
template <class T>
struct PoseOf {
  Eigen::Matrix3<T> R = Eigen::Matrix3<T>::Identity();  ///< R_AB, a rotation; its columns are B's axes in A
  Eigen::Vector3<T> p = Eigen::Vector3<T>::Zero();      ///< p_AB, B's origin in A, m

  PoseOf inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};
using Pose = PoseOf<double>;

/// X_AC = X_AB X_BC
template <class T, class U>
PoseOf<T> operator*(const PoseOf<T>& X_AB, const PoseOf<U>& X_BC) {
  return {X_AB.R * X_BC.R, X_AB.R * X_BC.p + X_AB.p};
}

/// Whether X.R is a rotation matrix within 1e-9 and X.p is finite.
inline bool is_rigid(const Pose& X) {
  return X.p.allFinite() && X.R.allFinite() &&
         (X.R * X.R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9 && X.R.determinant() > 0;
}

/// p_A = X_AB p_B: a point's coordinates in A from those in B.
template <class T, class Vector>
Eigen::Vector3<T> operator*(const PoseOf<T>& X_AB, const Eigen::MatrixBase<Vector>& p_B) {
  return X_AB.R * p_B + X_AB.p;
}

/// A quaternion (w, x, y, z). Rotations are unit quaternions; q and -q are the same rotation. (Not aligned,
/// so that programs compiled for wider vector registers can share it with this library.)
template <class T>
using QuaternionOf = Eigen::Matrix<T, 4, 1, Eigen::DontAlign>;
using Quaternion = QuaternionOf<double>;

inline Quaternion identity_quaternion() { return {1, 0, 0, 0}; }

/// The quaternion of R(a) R(b).
template <class A, class B>
auto product(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return QuaternionOf<decltype(a[0] * b[0])>{a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                                             a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                                             a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                                             a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

template <class A>
QuaternionOf<typename A::Scalar> conjugate(const Eigen::MatrixBase<A>& a) {
  return {a[0], -a[1], -a[2], -a[3]};
}

/// R of a unit quaternion.
template <class A>
Eigen::Matrix3<typename A::Scalar> rotation_matrix(const Eigen::MatrixBase<A>& a) {
  using T = typename A::Scalar;
  const T w = a[0], x = a[1], y = a[2], z = a[3];
  Eigen::Matrix3<T> R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R;
}

/// The unit quaternion of R with w >= 0 (Shepperd, J. Guidance and Control 1 (1978)). The entries of 4 q q^T
/// are sums of entries of R. A row with a large diagonal entry, normalised, is q.
template <class M>
QuaternionOf<typename M::Scalar> quaternion(const Eigen::MatrixBase<M>& matrix) {
  using T = typename M::Scalar;
  using Q = QuaternionOf<T>;
  const Eigen::Matrix3<T> R = matrix;
  const T x = R(2, 1) - R(1, 2), y = R(0, 2) - R(2, 0), z = R(1, 0) - R(0, 1);  // 4 w times x, y, z
  const T xy = R(0, 1) + R(1, 0), xz = R(0, 2) + R(2, 0), yz = R(1, 2) + R(2, 1);
  const T ww = 1 + R(0, 0) + R(1, 1) + R(2, 2), xx = 1 + R(0, 0) - R(1, 1) - R(2, 2),
          yy = 1 - R(0, 0) + R(1, 1) - R(2, 2), zz = 1 - R(0, 0) - R(1, 1) + R(2, 2);
  const Q row = either(
      ww >= 1, [&] { return Q(ww, x, y, z); },  // (then w^2 >= 1/4; otherwise x^2, y^2 or z^2 is)
      [&] {
        return Q(either(
            xx >= 1, [&] { return Q(x, xx, xy, xz); },
            [&] {
              return Q(either(
                  yy >= zz, [&] { return Q(y, xy, yy, yz); }, [&] { return Q(z, xz, yz, zz); }));
            }));
      });
  using std::sqrt;
  const T length = sqrt(row.squaredNorm());
  const T scale = either(
      row[0] < 0, [&] { return T(-1 / length); }, [&] { return T(1 / length); });
  return row * scale;
}

/// R of a rotation by `angle` (rad) about the unit vector `axis` (Rodrigues).
template <class Axis, class T>
Eigen::Matrix3<T> rotation_about(const Eigen::MatrixBase<Axis>& axis, const T& angle) {
  using std::cos, std::sin;
  const T s = sin(angle), c = cos(angle), rest = 1 - c;
  const T xs = axis[0] * s, ys = axis[1] * s, zs = axis[2] * s;
  const T xr = axis[0] * rest, yr = axis[1] * rest, zr = axis[2] * rest;
  const T xy = axis[1] * xr, xz = axis[2] * xr, yz = axis[2] * yr;
  Eigen::Matrix3<T> R;
  R << axis[0] * xr + c, xy - zs, xz + ys,  //
      xy + zs, axis[1] * yr + c, yz - xs,   //
      xz - ys, yz + xs, axis[2] * zr + c;
  return R;
}

}  // namespace borelli
