// The screw switch (helical): a rotation about a fixed axis with a proportional translation along it.
#pragma once

#include <string_view>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// X_AB = (rotation by q about axis, pitch q axis). q in rad, right-handed; v = dq/dt. The axis is the same
/// in A and B. A pitch of zero is a rotation.
template <class S>
struct ScrewOf {
  template <class Other>  // the same kind over another scalar type (articulated_side.hpp)
  using Over = ScrewOf<Other>;
  static constexpr std::string_view kind = "screw";
  static constexpr int nq = 1, nv = 1;
  static constexpr bool rotates = true;
  static constexpr bool slides = true;
  Eigen::Vector3<S> axis = Eigen::Vector3<S>::UnitZ();
  S pitch = 0;  ///< m per rad along the axis; negative: a left-handed thread

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("axis", self.axis);
    visit("pitch", self.pitch);
  }

  void scale_lengths(double s) { pitch *= s; }

  /// Moves the frame X from X_WA to X_WB. Gives the unit twist of the coordinate in W, at the origin of B.
  template <class T>
  void advance(const T* q, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear) const {
    angular[0] = X.R * axis;
    linear[0] = pitch * angular[0];
    X.p += q[0] * linear[0];
    X.R = X.R * rotation_about(axis, q[0]);
  }
};
using Screw = ScrewOf<double>;

}  // namespace borelli
