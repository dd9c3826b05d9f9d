// A rigid body, or several held rigid, as mass, first moment and inertia tensor about a frame's origin.
#pragma once

#include "dynamics/equations/kinematics.hpp"
#include "dynamics/numbers/symmetric.hpp"

namespace borelli {

/// A composite rigid body: a body and all that it carries; about its frame's origin, world axes.
template <class T>
struct CompositeBody {
  T mass = 0;
  Eigen::Vector3<T> first = Eigen::Vector3<T>::Zero();  ///< mass times gravity centre, kg m
  Symmetric3<T> second;                                 ///< inertia tensor, kg m^2

  CompositeBody& operator+=(const CompositeBody& other) {
    mass += other.mass;
    first += other.first;
    second += other.second;
    return *this;
  }
  /// Moves the origin by -r. The tensor grows by r.(h + h') 1 - h r^T - r h'^T, with h and h' the first
  /// moments before and after.
  void move(const Eigen::Vector3<T>& r) {
    const Eigen::Vector3<T> h = first, to = h + mass * r, sum = h + to;
    const T xx = r[0] * sum[0], yy = r[1] * sum[1], zz = r[2] * sum[2];
    second.xx += yy + zz, second.yy += xx + zz, second.zz += xx + yy;
    second.xy -= h[0] * r[1] + r[0] * to[1];
    second.xz -= h[0] * r[2] + r[0] * to[2];
    second.yz -= h[1] * r[2] + r[1] * to[2];
    first = to;
  }
};

/// A rigid body's inertia tensor about its gravity centre, in world axes.
template <class T, class Inertia>
Symmetric3<T> central_tensor(const Inertia& inertial, const BodyMotionOf<T>& m) {
  return turned<T>(m.X.R, inertial.tensor, has_principal_axes(inertial));
}

/// A rigid body about its frame's origin; `tensor`: its central_tensor.
template <class T>
CompositeBody<T> rigid_body(const T& mass, const Symmetric3<T>& tensor, const BodyMotionOf<T>& m) {
  const Eigen::Vector3<T> d = m.g - m.X.p;
  CompositeBody<T> out;
  out.mass = mass;
  out.first = mass * d;
  out.second = point_inertia<T>(mass, d);
  out.second += tensor;
  return out;
}

}  // namespace borelli
