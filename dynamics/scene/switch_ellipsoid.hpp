// The ellipsoid switch: a frame turns freely while its origin glides over an ellipsoid (scapula on thorax).
#pragma once

#include <string>
#include <string_view>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// X_AB = (R(q), D n) with n = R z, the z axis of B in A, and D = diag(radii). q is the unit quaternion
/// (w, x, y, z) of R_AB; v is the angular velocity of B in A in B's axes, rad/s, as for a ball. This is
/// Simbody's MobilizedBody::Ellipsoid (Seth, Sherman, Eastman, Delp, Minimal formulation of joint motion for
/// biomechanisms, Nonlinear Dynamics 62, 2010). z is the surface's normal for equal radii only.
struct OnEllipsoid {
  static constexpr std::string_view kind = "ellipsoid";
  static constexpr int nq = 4, nv = 3;
  static constexpr bool rotates = true;
  static constexpr bool slides = true;
  Eigen::Vector3d radii = Eigen::Vector3d::Ones();  ///< along the axes of A, m

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("radii", self.radii);
  }

  std::string complaint() const {
    return radii.minCoeff() > 0 ? "" : "has a radius of 0 or less; expected three positive lengths";
  }
  void scale_lengths(double s) { radii *= s; }

  /// Moves the frame X from X_WA to X_WB. Gives the unit twists about the axes of B, in W, at B's origin.
  template <class T>
  void advance(const T* q, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear) const {
    const T still[nv] = {T(0), T(0), T(0)};
    Eigen::Vector3<T> angular_rate, linear_rate;
    advance(q, still, X, angular, linear, angular_rate, linear_rate);
  }

  /// Also gives the rate of the twist at constant v, as seen from B, in W (Bending).
  template <class T>
  void advance(const T* q, const T* v, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear,
               Eigen::Vector3<T>& angular_rate, Eigen::Vector3<T>& linear_rate) const {
    const Eigen::Matrix3<T> A = X.R, R = rotation_matrix(QuaternionOf<T>(q[0], q[1], q[2], q[3]));
    const auto shifted = [&](const Eigen::Vector3<T>& n) {
      return Eigen::Vector3<T>(A * Eigen::Vector3<T>(radii[0] * n[0], radii[1] * n[1], radii[2] * n[2]));
    };
    const Eigen::Vector3<T> n = R.col(2);
    X.p += shifted(n);
    X.R = A * R;
    for (int i = 0; i < nv; ++i) angular[i] = X.R.col(i);
    linear[0] = shifted(-R.col(1));  // x cross z = -y
    linear[1] = shifted(R.col(0));
    linear[2].setZero();
    const Eigen::Vector3<T> turn = v[0] * R.col(0) + v[1] * R.col(1) + v[2] * n, n_rate = turn.cross(n);
    angular_rate.setZero();
    linear_rate = shifted(turn.cross(n_rate)) - Eigen::Vector3<T>(A * turn).cross(shifted(n_rate));
  }
};

}  // namespace borelli
