// Where the lines between a limb's bones lie along its way, by the sections and gaps of its bones.
#pragma once

#include "segmentation/limbs.hpp"

namespace borelli {

/// From where the tibia is half as thick again as at its narrowest to the ankle's centre, mm of an adult.
inline constexpr double flare_to_ankle = 42;

/// Where along a limb's way the lines between its bones lie, in mm from the root; 0 for one that is not in
/// view.
struct JointsAlongWay {
  double middle = 0;  ///< knee or elbow
  double end = 0;     ///< ankle or wrist
};

JointsAlongWay leg_joints(const LimbWay& way, double scale);
JointsAlongWay arm_joints(const LimbWay& way, double scale);

}  // namespace borelli
