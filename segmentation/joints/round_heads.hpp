// What is round among a body's bones and may be the head of a femur or humerus.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/spheres.hpp"

namespace borelli {

/// How well the edges about a ball agree on it, 0 to 1: its score, less where they scatter. About a true
/// sphere they scatter by a quarter of the scan's resolution, about a compromise of two by half of it.
inline double agreement(const Anatomy& anatomy, const FoundSphere& ball) {
  const double scatter = 0.4 * std::max(1.0, std::cbrt(anatomy.source->grid.voxel_volume()));
  return ball.score * std::exp(-std::pow(ball.deviation / scatter, 2));
}

class RoundHeads {
 public:
  explicit RoundHeads(const Anatomy& anatomy)
      : anatomy_(anatomy), votes_(vote_balls(anatomy.scan.hu, anatomy.bone, 17, 29, 8, anatomy.threads)) {}

  /// See vote_balls.
  const std::vector<FoundSphere>& votes() const { return votes_; }

  /// See fit_balls; of 14 to 36 mm, measured once about each place. Valid until the next place.
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
