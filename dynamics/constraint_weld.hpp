// Holonomic constraint: a solid keeps its pose in another solid or in the world (closes a rigid loop). Solids
// that are welded in the tree itself (fixed switches) need none: they are merged by compile().
#pragma once

#include <string_view>

#include "dynamics/pose.hpp"
#include "dynamics/site.hpp"

namespace borelli {

class ConstraintScan;

/// X_ba = `pose`: six rows; three of position (world axes, m), three of rotation: twice the vector part of
/// the quaternion of pose.R^T R_ba (a's axes, rad to first order), which vanishes at no other orientation.
struct WeldConstraint {
  static constexpr std::string_view kind = "weld";
  SolidName a, b;
  Pose pose;  ///< of a in b

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
    visit("pose", self.pose);
  }

  static constexpr int rows = 6;
  static constexpr int length_rows = 3;  ///< the first ones, which are in m
  void evaluate(ConstraintScan& scan) const;
};

}  // namespace borelli
