#include "pipeline/motion/solid_poses.hpp"

#include <algorithm>

namespace borelli {

int solid_index(const System& system, const std::string& name) {
  const auto found = std::find(system.solids.begin(), system.solids.end(), name);
  return found == system.solids.end() ? -1 : int(found - system.solids.begin());
}

void SolidPoses::update(double t, const Eigen::VectorXd& q) {
  update_kinematics(system_, system_.parameters, t, q.data(), nullptr, kinematics_);
}

Pose SolidPoses::of(int solid) const {
  if (solid < 0) return Pose{};
  const auto s = std::size_t(solid);
  return kinematics_.bodies[std::size_t(system_.solid_bodies[s])].X * system_.parameters.solid_places[s];
}

}  // namespace borelli
