// Inverse dynamics of a motion under measured forces: what the joints must do, and what remains at the root.
#pragma once

#include <vector>

#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// A force and a moment on a solid at one instant. World axes.
struct SolidWrench {
  int solid = 0;                                     ///< index in System::solids
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< N
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< m, where the force acts
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< N m, about the point
};

/// Inverse dynamics instant after instant. Nothing is allocated after construction.
class MotionEfforts {
 public:
  explicit MotionEfforts(const System& system);

  /// The generalised forces (nv, N or N m) that accelerations a (nv) at the state need beyond gravity, the
  /// scene's own efforts and the wrenches: tau = A a + B - Q - sum J^T f. The forces of constraints are not
  /// part of it: in closed loops tau is what all joints would need with the loops cut. Parameters are the
  /// system's unless others are given. The reference holds until the next call.
  const Eigen::VectorXd& needed(const State& state, const Eigen::VectorXd& a,
                                const std::vector<SolidWrench>& wrenches);
  const Eigen::VectorXd& needed(const Parameters& parameters, const State& state, const Eigen::VectorXd& a,
                                const std::vector<SolidWrench>& wrenches);

 private:
  const System& system_;
  Kinematics kinematics_;
  EffortSums efforts_;
  Articulation articulation_;
  std::vector<Eigen::Matrix<double, 6, 1>> carried_;  ///< per body: moment about the world's origin, force
  Eigen::VectorXd generalised_;                       ///< system.size(): of all switches, driven ones too
  Eigen::VectorXd needed_;                            ///< nv: the free ones, which come first
};

}  // namespace borelli
