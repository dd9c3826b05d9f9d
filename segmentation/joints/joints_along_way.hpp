// Where the lines between a limb's bones lie along its way, by the sections and gaps of its bones.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "segmentation/joints/limbs.hpp"

namespace borelli {

/// From where the tibia is half as thick again as at its narrowest to the ankle's centre, mm of an adult.
inline constexpr double flare_to_ankle = 42;

/// Where along a limb's way the lines between its bones lie, in mm from the root; 0 for one that is not in
/// view.
struct JointsAlongWay {
  double middle = 0;         ///< knee or elbow
  bool middle_seen = false;  ///< of a knee: by a gap or waist between its bones, not by their breadth alone
  double end = 0;            ///< ankle or wrist
};

JointsAlongWay leg_joints(const LimbWay& way, double scale);
JointsAlongWay arm_joints(const LimbWay& way, double scale);

/// A place on an arm's way that may be its wrist.
struct WristPlace {
  Eigen::Vector3d point;  ///< mm
  double log_odds = 0;    ///< against a place without a dip and of usual lengths
};

/// The places beyond the elbow (mm) where the bones' section dips between broader ones, in their order. On
/// voxels as large as the wrist's gap its dip may be shallower than that behind the carpus; the lengths of
/// forearm and hand then tell which it is.
std::vector<WristPlace> wrist_places(const LimbWay& way, const Eigen::Vector3d& elbow, double scale);

}  // namespace borelli
