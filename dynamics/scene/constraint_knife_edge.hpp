// Kinematic constraint: a blade (skate, keel, sharp wheel) slides along itself and not sideways.
#pragma once

#include <string_view>

#include "dynamics/scene/surface_contact.hpp"

namespace borelli {

/// d . (v_p - v_ground(p)) = 0: one row, m/s; p is a point of the blade, d its normal, fixed in its solid.
/// The multiplier is the lateral force on the blade. Something else must keep the blade on the ground: the
/// switches of a plane, or a `point_on_plane`.
struct KnifeEdge {
  static constexpr std::string_view kind = "knife_edge";
  SolidPoint blade;                                   ///< the point p
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< in its solid's axes
  SolidName ground;                                   ///< the solid it cuts into, or the world

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("blade", self.blade);
    visit("normal", self.normal);
    visit("ground", self.ground);
  }

  std::string complaint() const { return normal.norm() > 1e-12 ? "" : "its blade's normal has no direction"; }

  static constexpr int rows = 1;
  static constexpr int length_rows = 1;
  static constexpr int kinematic_rows = 1;

  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { blade_site, ground_site };
    const auto p = pass.point(blade_site, blade.point);
    const Eigen::Vector3<T> d = pass.frame(blade_site).R * normal;
    slip_row<T>(pass, 0, blade_site, ground_site, {p.p, p.v}, d, pass.angular_velocity(blade_site).cross(d));
  }
};

}  // namespace borelli
