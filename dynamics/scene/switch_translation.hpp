// The translation switch (prismatic, slider): q metres along a fixed axis.
#pragma once

#include <string_view>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// X_AB = (identity, q axis). q in m; v = dq/dt. The axis is the same in A and B.
template <class S>
struct TranslationOf {
  template <class Other>  // the same kind over another scalar type (articulated_side.hpp)
  using Over = TranslationOf<Other>;
  static constexpr std::string_view kind = "translation";
  static constexpr int nq = 1, nv = 1;
  static constexpr bool rotates = false;  ///< q is a length
  static constexpr bool slides = true;
  Eigen::Vector3<S> axis = Eigen::Vector3<S>::UnitZ();

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("axis", self.axis);
  }

  /// Moves the frame X from X_WA to X_WB. Gives the unit twist of the coordinate in W, at the origin of B: no
  /// rotation.
  template <class T>
  void advance(const T* q, PoseOf<T>& X, Eigen::Vector3<T>* angular, Eigen::Vector3<T>* linear) const {
    linear[0] = X.R * axis;
    angular[0].setZero();
    X.p += q[0] * linear[0];
  }
};
using Translation = TranslationOf<double>;

}  // namespace borelli
