#include "segmentation/joints/likeliest_head.hpp"

#include "segmentation/body/anatomy.hpp"

namespace borelli {

using Eigen::Vector3d;

std::optional<FoundSphere> find_shoulder_over(const FoundSphere& hip, int side, const Anatomy& a,
                                              const HeadsInBody& body, RoundHeads& candidates) {
  constexpr double lowest = 330, highest = 650, aside = 150, deep = 120;  // mm
  const double outwards = side_sign(side);
  return likeliest_head(a, body, candidates, [&](const FoundSphere& ball) {
    const Vector3d d = ball.centre - hip.centre;
    return d[2] > lowest && d[2] < highest && std::abs(d[1]) < deep && d[0] * outwards > 0 &&
           d[0] * outwards < aside && body.at_shoulder(ball.centre);
  });
}

FoundSphere mirror_image(FoundSphere ball, double middle) {
  ball.centre[0] = 2 * middle - ball.centre[0];
  return ball;
}

}  // namespace borelli
