// Where the forest has a pair of limbs begin: what tells their joints' heads from all else that is round.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/proposal/proposal.hpp"

namespace borelli {

/// Standard deviation of each coordinate of LimbRoots::joint, mm: rounded up from 20 mm, that of 62 roots in
/// warped bodies, each by a forest that had not seen that body.
inline constexpr double root_deviation = 25;

struct LimbRoots {
  LimbRoots() = default;  ///< nothing is known
  /// Of arms or legs, by the anatomy's proposal; without one nothing is known.
  LimbRoots(const Anatomy& anatomy, BodyRegion limb);

  /// By side: about where the head of humerus or femur is, patient frame, mm; empty where no limb of that
  /// side meets the trunk in bone.
  std::array<std::optional<Eigen::Vector3d>, 2> joint;
  std::array<double, 2> confidence{0, 0};  ///< of the limbs' pieces

  /// Both are known, and the forest is sure of both limbs.
  bool sure() const;
  /// Of a pair of places, 0 to 1: 1 where nothing is known.
  double likelihood(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
};

}  // namespace borelli
