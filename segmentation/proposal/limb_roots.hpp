// Roots of a pair of limbs by the forest: they distinguish femoral and humeral heads from other round bones.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/proposal/proposal.hpp"

namespace borelli {

/// Standard deviation of each coordinate of LimbRoots::joint, mm. Rounded up from 20 mm, measured at 62 roots
/// in warped bodies by forests trained without that body.
inline constexpr double root_deviation = 25;

struct LimbRoots {
  LimbRoots() = default;  ///< nothing is known
  /// Roots of the arms or legs from the anatomy's proposal; nothing is known without one.
  LimbRoots(const Anatomy& anatomy, BodyRegion limb);

  /// By side: estimated centre of the humeral or femoral head, LPS, mm. Empty if no limb of that side meets
  /// the trunk in bone.
  std::array<std::optional<Eigen::Vector3d>, 2> joint;
  std::array<double, 2> confidence{0, 0};  ///< of the limbs' pieces

  /// True if the side's root is known and the forest is sure of the limb.
  bool sure(int side) const;
  bool sure() const { return sure(0) && sure(1); }
  /// Likelihood of a pair of head centres (LPS, mm), 0 to 1; 1 if nothing is known.
  double likelihood(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
};

}  // namespace borelli
