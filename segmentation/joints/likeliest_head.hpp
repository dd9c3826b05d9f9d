// Finds the head of a femur or humerus on one side, where the other side shows none.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "segmentation/joints/heads_in_body.hpp"
#include "segmentation/joints/round_heads.hpp"

namespace borelli {

/// The most probable sphere that passes `fits(ball)`, searched about the best votes that pass it. Empty if no
/// solid sphere passes.
template <class Fits>
std::optional<FoundSphere> likeliest_head(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates,
                                          const Fits& fits) {
  constexpr std::size_t most_places = 8;
  constexpr double same = 15, again = 1;  // mm, between places; see find_heads in trunk.cpp
  std::optional<FoundSphere> best;
  double most = 0;
  std::vector<Eigen::Vector3d> places;
  const auto search_near = [&](const Eigen::Vector3d& place, double reach) {
    if (std::any_of(places.begin(), places.end(),
                    [&](const Eigen::Vector3d& other) { return (other - place).norm() < reach; }))
      return false;
    places.push_back(place);
    for (const FoundSphere& ball : candidates.about(place)) {
      // same score as of a pair of equal heads
      const double score = std::pow(agreement(a, ball), 2) * head_size(ball.radius);
      if (score > most && fits(ball) && body.solid(ball)) most = score, best = ball;
    }
    return true;
  };
  for (const FoundSphere& vote : candidates.votes())
    if (places.size() < most_places && fits(vote)) search_near(vote.centre, same);
  for (int round = 0; round < 3 && best && search_near(best->centre, again);) ++round;
  return best;
}

/// Finds the humeral head above `hip` on the same side, with the top of a lung beside and below it. Empty if
/// there is none.
std::optional<FoundSphere> find_shoulder_over(const FoundSphere& hip, int side, const Anatomy& anatomy,
                                              const HeadsInBody& body, RoundHeads& candidates);

/// The sphere mirrored in the sagittal plane x = `middle` (mm, LPS).
FoundSphere mirror_image(FoundSphere ball, double middle);

}  // namespace borelli
