// The ball switch (spherical): any rotation about a point, by a quaternion.
#pragma once

#include <string_view>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// X_AB = (R(q), 0). q is the unit quaternion (w, x, y, z) of R_AB; v is the angular velocity of B in A in
/// B's axes (the body angular velocity), rad/s: dq/dt = q (0, v) / 2.
struct Ball {
  static constexpr std::string_view kind = "ball";
  static constexpr int nq = 4, nv = 3;
  static constexpr bool rotates = true;
  static constexpr bool slides = false;
  static constexpr bool turns_freely = true;  ///< reaches every rotation, by twists along the axes of B

  template <class Self, class Visit>
  static void fields(Self&, Visit&&) {}

  /// Moves the frame X from X_WA to X_WB. The unit twists, in W, are rotations about the axes of B.
  template <class T>
  void advance(const T* q, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear) const {
    X.R = X.R * rotation_matrix(QuaternionOf<T>(q[0], q[1], q[2], q[3]));
    for (int i = 0; i < 3; ++i) {
      angular[i] = X.R.col(i);
      linear[i].setZero();
    }
  }
};

}  // namespace borelli
