// The likeliest head of a femur or humerus on one side, where no pair tells it.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "segmentation/heads_in_body.hpp"
#include "segmentation/round_heads.hpp"

namespace borelli {

/// The likeliest head about the best voted places that fit.
template <class Fits>
std::optional<FoundSphere> likeliest_head(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates,
                                          const Fits& fits) {
  constexpr std::size_t most_places = 8;
  constexpr double same = 15, again = 1;  // mm, between places; see find_heads in trunk.cpp
  const double scatter = 0.4 * std::max(1.0, std::cbrt(a.source->grid.voxel_volume()));
  std::optional<FoundSphere> best;
  double most = 0;
  std::vector<Eigen::Vector3d> places;
  const auto look_about = [&](const Eigen::Vector3d& place, double reach) {
    if (std::any_of(places.begin(), places.end(),
                    [&](const Eigen::Vector3d& other) { return (other - place).norm() < reach; }))
      return false;
    places.push_back(place);
    for (const FoundSphere& ball : candidates.about(place)) {
      // as of a pair that are alike
      const double score = std::pow(ball.score * std::exp(-std::pow(ball.deviation / scatter, 2)), 2) *
                           std::exp(-std::pow((ball.radius - 25) / 7, 2));
      if (score > most && fits(ball) && body.solid(ball)) most = score, best = ball;
    }
    return true;
  };
  for (const FoundSphere& vote : candidates.votes())
    if (places.size() < most_places && fits(vote)) look_about(vote.centre, same);
  for (int round = 0; round < 3 && best && look_about(best->centre, again);) ++round;
  return best;
}

/// The humeral head over a hip, on the same side: a lung's top beside and below it.
std::optional<FoundSphere> find_shoulder_over(const FoundSphere& hip, int side, const Anatomy& anatomy,
                                              const HeadsInBody& body, RoundHeads& candidates);

/// The ball in a sagittal plane's mirror (`middle`: mm, patient x).
FoundSphere mirror_image(FoundSphere ball, double middle);

}  // namespace borelli
