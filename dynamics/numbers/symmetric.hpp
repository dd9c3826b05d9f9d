// A symmetric 3x3 matrix stored by its six distinct entries, such as an inertia tensor.
#pragma once

#include "dynamics/numbers/pose.hpp"

namespace borelli {

template <class T>
struct Symmetric3 {
  T xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  Eigen::Vector3<T> operator*(const Eigen::Vector3<T>& a) const {
    return {xx * a[0] + xy * a[1] + xz * a[2], xy * a[0] + yy * a[1] + yz * a[2],
            xz * a[0] + yz * a[1] + zz * a[2]};
  }
  Symmetric3& operator+=(const Symmetric3& b) {
    xx += b.xx, xy += b.xy, xz += b.xz, yy += b.yy, yz += b.yz, zz += b.zz;
    return *this;
  }
  /// Subtracts a b^T, which must be symmetric.
  void subtract(const Eigen::Vector3<T>& a, const Eigen::Vector3<T>& b) {
    xx -= a[0] * b[0], xy -= a[0] * b[1], xz -= a[0] * b[2];
    yy -= a[1] * b[1], yz -= a[1] * b[2], zz -= a[2] * b[2];
  }
  T trace() const { return xx + yy + zz; }

  template <class Matrix>
  static Symmetric3 upper_of(const Matrix& M) {
    return {M(0, 0), M(0, 1), M(0, 2), M(1, 1), M(1, 2), M(2, 2)};
  }
  Eigen::Matrix3<T> full() const {
    Eigen::Matrix3<T> M;
    M << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return M;
  }
};

/// The product A B, which must be symmetric.
template <class A, class B>
Symmetric3<typename A::Scalar> symmetric_product(const A& a, const B& b) {
  const auto entry = [&](int i, int j) { return a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j); };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

/// Whether a tensor is diagonal, so that its axes are principal; for lane types, in every lane.
template <class Tensor>
bool has_principal_axes(const Tensor& tensor) {
  return everywhere(tensor(0, 1) == 0) && everywhere(tensor(0, 2) == 0) && everywhere(tensor(1, 2) == 0);
}

/// tensor a. Cheaper if its axes are `principal` ones.
template <class T, class Tensor>
Eigen::Vector3<T> times(const Tensor& tensor, bool principal, const Eigen::Vector3<T>& a) {
  if (principal) return {tensor(0, 0) * a[0], tensor(1, 1) * a[1], tensor(2, 2) * a[2]};
  return tensor * a;
}

/// R tensor R^T: rotates the tensor of a body from its own axes to world axes, R = R_WB. Cheaper if the own
/// axes are `principal` ones.
template <class T, class Tensor>
Symmetric3<T> turned(const Eigen::Matrix3<T>& R, const Tensor& tensor, bool principal) {
  Eigen::Matrix3<T> half;
  if (principal)
    for (int j = 0; j < 3; ++j) half.col(j) = tensor(j, j) * R.col(j);
  else
    half = R * tensor;
  return symmetric_product(half, R.transpose());
}

/// -m [d]x [d]x: inertia tensor about a point of a mass m at the offset d from it, kg m^2.
template <class T>
Symmetric3<T> point_inertia(const T& m, const Eigen::Vector3<T>& d) {
  const T x = m * d[0], y = m * d[1], z = m * d[2];
  const T xx = x * d[0], yy = y * d[1], zz = z * d[2];
  return {yy + zz, -x * d[1], -x * d[2], xx + zz, -y * d[2], xx + yy};
}

}  // namespace borelli
