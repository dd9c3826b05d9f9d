// A plane fixed in a solid or in the world: what points and forms stay on, or over.
#pragma once

#include <Eigen/Core>
#include <string>

#include "dynamics/scene/site.hpp"

namespace borelli {

/// Through the point `on`, in the solid that carries it; `normal` in that solid's axes, out of the matter
/// where there is any, made unit by compile().
struct Plane {
  SolidPoint on;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();

  /// Its fields stand among those of the constraint that it is part of.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("plane", self.on);
    visit("normal", self.normal);
  }

  std::string complaint() const { return normal.norm() > 1e-12 ? "" : "its plane's normal has no direction"; }
};

}  // namespace borelli
