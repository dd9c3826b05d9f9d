// Ground forces that a walking body needs, shared between its feet.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/inverse/motion_efforts.hpp"
#include "dynamics/inverse/recorded_motion.hpp"
#include "pipeline/body/foot_soles.hpp"
#include "pipeline/motion/walk_plan.hpp"
#include "pipeline/recordings/external_loads.hpp"

namespace borelli {

/// A force and its moment about the world's origin. World axes, N, N m.
struct GroundWrench {
  Eigen::Vector3d force, moment;
  /// Where its horizontal moments vanish on the floor z = 0: the centre of pressure (zero-moment point).
  Eigen::Vector2d pressure() const { return {-moment.y() / force.z(), moment.x() / force.z()}; }
};

/// What the ground must do to a free body (root "lower_trunk") for a motion.
class RootWrenches {
 public:
  explicit RootWrenches(const System& system);
  GroundWrench needed(const State& state, const Eigen::VectorXd& a);

 private:
  const System& system_;
  MotionEfforts efforts_;
  int solid_;
  std::vector<int> root_;  ///< the root's six velocity components
};

struct WalkLoads {
  std::vector<ExternalLoad> loads;  ///< one a foot; NaN points where it bears nothing
  std::vector<std::string> warnings;
};

/// At the times, s. One foot bears all; in double support the shares are those of planned_share, and the
/// centre of pressure of both feet is off the planned one by the same vector. Warns where a foot's leaves its
/// sole, by more than 2 cm.
WalkLoads walk_loads(const System& system, const RecordedMotion& motion, const std::vector<double>& times,
                     const std::array<WalkingFoot, 2>& feet, const WalkTiming& timing,
                     const FootSoles& soles);

}  // namespace borelli
