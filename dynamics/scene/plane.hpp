// A plane fixed in a solid or in the world, for constraints and contacts.
#pragma once

#include <Eigen/Core>
#include <string>

#include "dynamics/scene/site.hpp"

namespace borelli {

/// The plane through the point `on`, fixed in the solid of that point. `normal` is in the axes of that solid;
/// it points out of the material of a contact. compile() makes it unit.
struct Plane {
  SolidPoint on;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();

  /// In files its fields stand among those of the constraint that contains it.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("plane", self.on);
    visit("normal", self.normal);
  }

  std::string complaint() const { return normal.norm() > 1e-12 ? "" : "its plane's normal has no direction"; }
};

}  // namespace borelli
