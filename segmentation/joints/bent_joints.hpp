// Centre and axis of a strongly bent knee or elbow, from the lines of the two shafts.
#pragma once

#include <optional>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"

namespace borelli {

struct BentJoint {
  Eigen::Vector3d centre;  ///< midpoint between the nearest points of the two lines, mm
  Eigen::Vector3d axis;    ///< unit, perpendicular to both lines, of either sign
};

/// Intersects the shaft lines on the two sides of a joint. `middle`: position of the joint along the limb's
/// path, mm. Each shaft stretch runs from `near` to `far` mm from there. Empty if the joint is bent by less
/// than 45 degrees (the nearest points are then ill-conditioned), if it is folded shut, if a stretch is not
/// in view, or if the lines miss each other by more than 25 mm.
std::optional<BentJoint> bent_joint(const Anatomy& anatomy, const Limbs& limbs, Limb limb, double middle,
                                    double near, double far);

}  // namespace borelli
