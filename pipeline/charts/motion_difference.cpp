#include "pipeline/charts/motion_difference.hpp"

#include <algorithm>
#include <cmath>

namespace borelli {

void MotionDifference::widen(const MotionDifference& other) {
  position = std::max(position, other.position);
  orientation = std::max(orientation, other.orientation);
}

std::vector<Eigen::Vector3d> gravity_centres(const Scene& scene) {
  std::vector<Eigen::Vector3d> centres;
  for (const Solid& solid : scene.solids) {
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    double mass = 0;
    const auto parts = inertials_of(solid).value();  // compile has checked them
    for (const Inertial& part : parts) {
      moment += part.mass * part.centre;
      mass += part.mass;
    }
    centres.push_back(mass > 0 ? Eigen::Vector3d(moment / mass) : Eigen::Vector3d::Zero());
  }
  return centres;
}

MotionDifference pose_difference(const Pose& a, const Pose& b, const Eigen::Vector3d& centre) {
  const double chord = (a.R - b.R).norm() / std::sqrt(8.);  // the sine of half the angle between them
  return {(a * centre - b * centre).norm(), 2 * std::asin(std::min(1., chord))};
}

MotionDifference motion_difference(const Pose* a, const Pose* b,
                                   const std::vector<Eigen::Vector3d>& centres) {
  MotionDifference worst;
  for (std::size_t s = 0; s < centres.size(); ++s) worst.widen(pose_difference(a[s], b[s], centres[s]));
  return worst;
}

}  // namespace borelli
