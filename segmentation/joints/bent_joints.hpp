// A knee or elbow that is well bent: where the lines of the shafts on its two sides meet.
#pragma once

#include <optional>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"

namespace borelli {

struct BentJoint {
  Eigen::Vector3d centre;  ///< half way between the lines' nearest points, mm
  Eigen::Vector3d axis;    ///< unit, square to both lines, either way
};

/// `middle`: where along the way the joint lies, mm; `near`, `far`: the stretches of shaft looked at begin
/// and end so far from it on both sides, mm. Nothing where the joint is bent by less than 45 degrees (the
/// lines' nearest points are then poorly told), a stretch is not in view, or the lines miss each other by
/// more than 25 mm.
std::optional<BentJoint> bent_joint(const Anatomy& anatomy, const Limbs& limbs, Limb limb, double middle,
                                    double near, double far);

}  // namespace borelli
