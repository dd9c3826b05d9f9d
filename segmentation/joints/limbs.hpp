// The way along the bones of each limb, from its root at the hip or shoulder to its far end.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/grid/geodesic.hpp"
#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// Which limb's bones a place is nearest to, along bones: the owners of `Limbs::territory`.
enum class Limb : std::uint8_t { none, leg_left, leg_right, arm_left, arm_right, axial };

struct LimbWay {
  bool present = false;
  bool cut = false;                     ///< the way ends where the scan does
  bool headless = false;                ///< its root is where the scan cuts the bone, not a head
  std::vector<Eigen::Vector3d> points;  ///< from root to end, one every `spacing` mm of way, smoothed; mm
  std::vector<double> section;          ///< area of bone that lies as far from the root, mm^2, per point
  std::vector<double> off_bone;         ///< distance to bone at the point, mm (a joint's gap: above 0)
  std::vector<char> at_edge;            ///< 1 where bone so far from the root is cut by the scan's edge
  static constexpr double spacing = 3;
  /// Of the point at or before `s` mm from the root; of a way that is present.
  std::size_t index(double s) const {
    return std::min(points.size() - 1, static_cast<std::size_t>(std::max(0.0, s) / spacing));
  }
  double length() const { return points.empty() ? 0 : spacing * static_cast<double>(points.size() - 1); }
};

struct Limbs {
  Geodesic territory;  ///< ways along bones from heads and trunk; length in mm (gaps count for more)
  std::array<LimbWay, 5> way{};  ///< by Limb; [0] unused

  const LimbWay& leg(int side) const { return way[static_cast<std::size_t>(side) + 1]; }
  const LimbWay& arm(int side) const { return way[static_cast<std::size_t>(side) + 3]; }
  bool arms_meet = false;  ///< what is next to bone of one arm borders on what is next to the other's
  /// True at bone of an arm and in the flesh next to it.
  bool arm_at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const auto owner = static_cast<Limb>(territory.owner.at(i, j, k));
    return owner == Limb::arm_left || owner == Limb::arm_right;
  }
};

/// A step along bone costs its length, off bone more with the square of the distance to it, so that ways keep
/// to bones and cross no more than joints' gaps: neither skin touching skin nor thick slices that fuse the
/// bones of one limb lead them astray. Each bone voxel goes to the nearest of the four heads and the trunk's
/// own bones.
Limbs trace_limbs(const Anatomy& anatomy, const Trunk& trunk);

}  // namespace borelli
