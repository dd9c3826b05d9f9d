// Poses of a system's solids at given positions.
#pragma once

#include <Eigen/Core>
#include <string>

#include "dynamics/equations/kinematics.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// Index of a solid in System::solids; -1: the system has none of this name.
int solid_index(const System& system, const std::string& name);

class SolidPoses {
 public:
  explicit SolidPoses(const System& system) : system_(system), kinematics_(system, Equations::recursive) {}

  /// Goes to positions q (nq) at time t, s.
  void update(double t, const Eigen::VectorXd& q);
  /// X_WS of a solid by its index; -1: the world.
  Pose of(int solid) const;

 private:
  const System& system_;
  Kinematics kinematics_;
};

}  // namespace borelli
