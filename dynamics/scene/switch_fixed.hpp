// The fixed switch: a constant placement, with no coordinate.
#pragma once

#include <string_view>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// X_AB is constant. compile() fuses it with its neighbours; it costs nothing at run time.
struct Fixed {
  static constexpr std::string_view kind = "fixed";
  static constexpr int nq = 0, nv = 0;
  static constexpr bool rotates = false;
  static constexpr bool slides = false;
  Pose X_AB;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("pose", self.X_AB);
  }

  void scale_lengths(double s) { X_AB.p *= s; }

  template <class T>
  void advance(const T*, PoseOf<T>& X, Eigen::Vector3<T>*, Eigen::Vector3<T>*) const {
    X = X * X_AB;
  }
};

}  // namespace borelli
