// Rigid transforms and unit quaternions in monogram notation: X_AB = (R_AB, p_AB) places frame B in frame A.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace borelli {

/// X_AB: the pose of frame B in frame A. A point with coordinates p_B in B has R p_B + p in A. Metres.
struct Pose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< R_AB, a rotation; its columns are B's axes in A
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< p_AB, B's origin in A, m

  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// X_AC = X_AB X_BC
inline Pose operator*(const Pose& X_AB, const Pose& X_BC) {
  return {X_AB.R * X_BC.R, X_AB.R * X_BC.p + X_AB.p};
}

/// Whether X is a rotation, to 1e-9, and a finite place.
inline bool is_rigid(const Pose& X) {
  return X.p.allFinite() && X.R.allFinite() &&
         (X.R * X.R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9 && X.R.determinant() > 0;
}

/// p_A = X_AB p_B: a point's coordinates in A from those in B.
inline Eigen::Vector3d operator*(const Pose& X_AB, const Eigen::Vector3d& p_B) {
  return X_AB.R * p_B + X_AB.p;
}

/// A quaternion (w, x, y, z). Rotations are unit quaternions; q and -q are the same rotation. (Not aligned,
/// so that programs compiled for wider vector registers can share it with this library.)
using Quaternion = Eigen::Matrix<double, 4, 1, Eigen::DontAlign>;

inline Quaternion identity_quaternion() { return {1, 0, 0, 0}; }

/// The quaternion of R(a) R(b).
inline Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

inline Quaternion conjugate(const Quaternion& a) { return {a[0], -a[1], -a[2], -a[3]}; }

/// R of a unit quaternion.
inline Eigen::Matrix3d rotation_matrix(const Quaternion& a) {
  const double w = a[0], x = a[1], y = a[2], z = a[3];
  Eigen::Matrix3d R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R;
}

/// The unit quaternion of R with w >= 0.
inline Quaternion quaternion(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond e(R);
  const double sign = e.w() < 0 ? -1 : 1;
  return Quaternion(e.w(), e.x(), e.y(), e.z()) * (sign / e.norm());
}

/// R of a rotation by `angle` (rad) about the unit vector `axis` (Rodrigues).
inline Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

}  // namespace borelli
