// The rotation switch (revolute, hinge, pin): q radians about a fixed axis.
#pragma once

#include <string_view>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// X_AB = (rotation by q about axis, 0). q in rad, right-handed; v = dq/dt. The axis is the same in A and B.
template <class S>
struct RotationOf {
  template <class Other>  // the same kind over another scalar type (articulated_side.hpp)
  using Over = RotationOf<Other>;
  static constexpr std::string_view kind = "rotation";
  static constexpr int nq = 1, nv = 1;
  static constexpr bool rotates = true;  ///< q is an angle
  static constexpr bool slides = false;  ///< its unit twist has no linear part
  Eigen::Vector3<S> axis = Eigen::Vector3<S>::UnitZ();

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("axis", self.axis);
  }

  /// Moves the frame X from X_WA to X_WB. Gives the unit twist of the coordinate in W, at the origin of B,
  /// which is at rest.
  template <class T>
  void advance(const T* q, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear) const {
    angular[0] = X.R * axis;
    linear[0].setZero();
    X.R = X.R * rotation_about(axis, q[0]);
  }
};
using Rotation = RotationOf<double>;

}  // namespace borelli
