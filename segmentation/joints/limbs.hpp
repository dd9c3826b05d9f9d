// The path along the bones of each limb, from its root at the hip or shoulder to its far end.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/grid/geodesic.hpp"
#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// The limb whose bones are nearest to a voxel, measured along bones: the owner in `Limbs::territory`.
enum class Limb : std::uint8_t { none, leg_left, leg_right, arm_left, arm_right, axial };

struct LimbPath {
  bool present = false;
  bool cut = false;                     ///< the path ends at the scan's edge
  bool headless = false;                ///< its root is a section of the shaft that the scan cuts, not a head
  std::vector<Eigen::Vector3d> points;  ///< from root to end, every `spacing` mm of path, smoothed; mm, LPS
  std::vector<double> section;          ///< bone area at that distance from the root, mm^2, per point
  std::vector<double> off_bone;         ///< distance to bone at the point, mm (above 0 in a joint's gap)
  std::vector<char> at_edge;            ///< 1 if the scan's edge cuts bone at that distance from the root
  static constexpr double spacing = 3;
  /// Index of the point at or before `s` mm from the root. The limb must be present.
  std::size_t index(double s) const {
    return std::min(points.size() - 1, static_cast<std::size_t>(std::max(0.0, s) / spacing));
  }
  double length() const { return points.empty() ? 0 : spacing * static_cast<double>(points.size() - 1); }
};

struct Limbs {
  Geodesic territory;              ///< paths along bones from heads and trunk; length in mm, gaps weighted
  std::array<LimbPath, 5> path{};  ///< by Limb; [0] unused

  const LimbPath& leg(int side) const { return path[static_cast<std::size_t>(side) + 1]; }
  const LimbPath& arm(int side) const { return path[static_cast<std::size_t>(side) + 3]; }
  bool arms_meet = false;  ///< the two arms' bones, with the flesh next to them, touch
  /// True in an arm's bones and in the flesh next to them.
  bool arm_at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const auto owner = static_cast<Limb>(territory.owner.at(i, j, k));
    return owner == Limb::arm_left || owner == Limb::arm_right;
  }
};

/// Finds the cheapest paths along bones. A step in bone costs its length; off bone the cost grows with the
/// square of the distance to bone. So paths keep to bones and cross only the gaps of joints. Touching skin
/// does not divert them, nor do thick slices that fuse the bones of one limb. Each bone voxel belongs to the
/// nearest of the four heads and the trunk's own bones.
Limbs trace_limbs(const Anatomy& anatomy, const Trunk& trunk);

}  // namespace borelli
