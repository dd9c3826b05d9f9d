// Round places among a body's bones: candidates for femoral and humeral heads.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/spheres.hpp"

namespace borelli {

/// Quality of a sphere, 0 to 1: its score, reduced if the edges scatter. About a true sphere the scatter is a
/// quarter of the scan's resolution; about a compromise of two spheres it is half.
inline double agreement(const Anatomy& anatomy, const FoundSphere& ball) {
  const double scatter = 0.4 * std::max(1.0, std::cbrt(anatomy.source->grid.voxel_volume()));
  return ball.score * std::exp(-std::pow(ball.deviation / scatter, 2));
}

/// Likelihood of a head's radius (mm), 0 to 1: heads of adults have 19 to 29 mm.
inline double head_size(double radius) { return std::exp(-std::pow((radius - 25) / 7, 2)); }

class RoundHeads {
 public:
  explicit RoundHeads(const Anatomy& anatomy)
      : anatomy_(anatomy), votes_(vote_balls(anatomy.scan.hu, anatomy.bone, 17, 29, 8, anatomy.threads)) {}

  /// See vote_balls.
  const std::vector<FoundSphere>& votes() const { return votes_; }

  /// See fit_balls, with radii of 14 to 36 mm; cached per place. The reference is valid until the next new
  /// place.
  const std::vector<FoundSphere>& about(const Eigen::Vector3d& place) {
    for (const auto& [known, balls] : measured_)
      if (known == place) return balls;
    return measured_.emplace_back(place, fit_balls(*anatomy_.source, place, 14, 36, anatomy_.threads)).second;
  }

 private:
  const Anatomy& anatomy_;
  std::vector<FoundSphere> votes_;
  std::vector<std::pair<Eigen::Vector3d, std::vector<FoundSphere>>> measured_;
};

}  // namespace borelli
