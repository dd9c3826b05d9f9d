// Plans where the feet of a walking body are, and where the floor presses on them.
#pragma once

#include <array>
#include <string>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"
#include "pipeline/body/foot_soles.hpp"

namespace borelli {

/// A foot as it stands in the scan's pose. World: the patient's axes, m; the person looks along -y.
struct WalkingFoot {
  std::string solid;
  Pose X_WS;              ///< of its frame in the scan's pose
  Eigen::Vector3d heel;   ///< sole point, in the foot's frame
  Eigen::Vector3d front;  ///< likewise, below the foremost metatarsal head, about which the heel rises
  double inward = 0;      ///< m, added to x: feet are nearer to each other in walking than in standing
  double lead = 0;        ///< share of the cycle by which its heel strikes after the right one's
};

struct WalkTiming {
  double speed = 1.2;       ///< m/s
  double cycle = 12 / 11.;  ///< s, from heel strike to heel strike of the same foot
  double stride() const { return speed * cycle; }
};

/// The feet, right and left. `width`: m, between the heels. Errors: a foot without three points of its sole.
Result<std::array<WalkingFoot, 2>> walking_feet(const std::map<std::string, Pose, std::less<>>& poses,
                                                const FootSoles& soles, double width);

/// Pose X_WS of a foot at a time in cycles. While it stands, it turns about its heel, lies flat, and then
/// turns about the metatarsal head; its pitch is that of leg_angles. The floor is z = 0. In the swing the
/// point that leads changes from metatarsal head to heel, on a smooth arc.
Pose planned_foot(const WalkingFoot& foot, const WalkTiming& timing, double cycles);

/// Planned share of the load on a foot: 1 in single support, smooth over double support.
double planned_share(const WalkingFoot& foot, double cycles);

/// Where the floor is to press on a standing foot, from heel to metatarsal heads.
Eigen::Vector3d planned_pressure(const WalkingFoot& foot, const WalkTiming& timing, double cycles);

}  // namespace borelli
