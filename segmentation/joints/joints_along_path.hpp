// Positions of the joints along a limb's path, from the cross sections of its bones and the gaps between
// them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "segmentation/joints/limbs.hpp"

namespace borelli {

/// Distance along the tibia from where its section is 1.4 times the shaft's to the ankle centre, mm in an
/// adult.
inline constexpr double flare_to_ankle = 42;

/// Positions along a limb's path, mm from its root; 0 for a joint out of view.
struct JointsAlongPath {
  double middle = 0;         ///< knee or elbow
  bool middle_seen = false;  ///< knee: located by a gap or waist, not only by the widest place
  double end = 0;            ///< ankle or wrist
};

/// Joints on a leg's or an arm's path. `scale`: the body's size, see Trunk.
JointsAlongPath leg_joints(const LimbPath& path, double scale);
JointsAlongPath arm_joints(const LimbPath& path, double scale);

/// A candidate wrist on an arm's path.
struct WristPlace {
  Eigen::Vector3d point;  ///< mm, LPS
  double log_odds = 0;    ///< against a place without a dip and of usual lengths
};

/// Candidate wrists distal to the elbow (mm), in order along the path: dips of the bones' section between
/// broader places. On voxels as large as the wrist's gap, the dip distal to the carpus may be the deeper one;
/// the lengths of forearm and hand then decide.
std::vector<WristPlace> wrist_places(const LimbPath& path, const Eigen::Vector3d& elbow, double scale);

/// Share of forearm and hand that the hand's bones make up, along the path (mm) from the elbow: mean and standard
/// deviation in phantoms and in de Leva (1996).
inline constexpr double hand_share = 0.40, hand_share_varies = 0.025;

/// Where that share puts the wrist on an arm's path (mm, LPS), and the length of forearm and hand along the bones.
/// Empty if less than 200 mm of path lie beyond the elbow.
struct UsualWrist {
  Eigen::Vector3d point;
  double length = 0;
};
std::optional<UsualWrist> usual_wrist(const LimbPath& path, const Eigen::Vector3d& elbow);

}  // namespace borelli
