// A pendant: a body that carries nothing, on a ball at its frame's origin. Its articulated inertia after
// eliminating the ball is constant in the body's own axes, and so computed once.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "dynamics/numbers/symmetric.hpp"
#include "inertia/inertial.hpp"

namespace borelli {

/// Least roundness det I / (tr I)^3 (1/27 for a sphere) of a tensor that is inverted at once. Inverting a
/// thinner one loses digits.
inline constexpr double least_roundness = 1e-5;

/// In the body's axes, about its frame's origin; SI. Because the body turns, a force on the origin meets only
/// the mass matrix mass 1 - yields[0] yields[0]^T - yields[1] yields[1]^T.
template <class T>
struct PendantOf {
  Symmetric3<T> I, inverse;                         ///< tensor and its inverse
  Eigen::Vector3<T> h = Eigen::Vector3<T>::Zero();  ///< mass times gravity centre
  Eigen::Vector3<T> yields[2] = {Eigen::Vector3<T>::Zero(), Eigen::Vector3<T>::Zero()};
  T roundness = 0;  ///< det I / (tr I)^3; `inverse` and `yields` are valid if it exceeds least_roundness
};

inline PendantOf<double> find_pendant(const Inertial& inertial) {
  const Eigen::Vector3d& c = inertial.centre;
  PendantOf<double> out;
  out.h = inertial.mass * c;
  Eigen::Matrix3d I = inertial.tensor - out.h * c.transpose();
  I.diagonal().array() += out.h.dot(c);
  out.I = Symmetric3<double>::upper_of(I);
  Eigen::Matrix3d minors;
  for (int j = 0; j < 3; ++j) minors.col(j) = I.col((j + 1) % 3).cross(I.col((j + 2) % 3));
  const double determinant = I.col(0).dot(minors.col(0)), size = I.trace();
  if (!(size > 0)) return out;
  out.roundness = determinant / (size * size * size);
  if (!(out.roundness > least_roundness)) return out;
  const Eigen::Matrix3d inverse = minors / determinant;
  out.inverse = Symmetric3<double>::upper_of(inverse);
  // [h]x^T I^-1 [h]x has rank two at most, since [h]x h = 0: two steps of pivoted Cholesky factor it.
  Eigen::Matrix3d H;
  H << 0, -out.h[2], out.h[1], out.h[2], 0, -out.h[0], -out.h[1], out.h[0], 0;
  Eigen::Matrix3d left = H.transpose() * inverse * H;
  for (Eigen::Vector3d& axis : out.yields) {
    int greatest;
    const double square = left.diagonal().maxCoeff(&greatest);
    if (!(square > 0)) break;
    axis = left.col(greatest) / std::sqrt(square);
    left -= axis * axis.transpose();
  }
  return out;
}

/// Sets one lane.
template <class T>
void set_lane(int lane, const PendantOf<double>& from, PendantOf<T>& to) {
  const auto set = [&](const Symmetric3<double>& a, Symmetric3<T>& b) {
    b.xx.set(lane, a.xx), b.xy.set(lane, a.xy), b.xz.set(lane, a.xz);
    b.yy.set(lane, a.yy), b.yz.set(lane, a.yz), b.zz.set(lane, a.zz);
  };
  set(from.I, to.I), set(from.inverse, to.inverse);
  for (int i = 0; i < 3; ++i) {
    to.h[i].set(lane, from.h[i]);
    for (int n : {0, 1}) to.yields[n][i].set(lane, from.yields[n][i]);
  }
  to.roundness.set(lane, from.roundness);
}

}  // namespace borelli
