// Joint reactions: the force and moment on a solid from its parent, through a joint that moves or is driven,
// locked or welded.
#pragma once

#include <memory>

#include "dynamics/equations/recursive.hpp"
#include "dynamics/scene/contact.hpp"

namespace borelli {

/// Load on the solid from its parent, world axes. It includes the bearing load and the forces of springs,
/// drives, controllers, limits and couplings on the joint's own coordinates. (An armature's rotor counts as
/// outside: the torque that accelerates it is not transmitted.)
struct JointReaction {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< m: origin of the frame after the joint's last moving
                                                     ///< switch; of a weld, the solid's origin
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< N
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< N m, about `point`
  Eigen::Matrix3d R_WP = Eigen::Matrix3d::Identity();  ///< the parent's axes: R_WP^T force is in them
  bool unique =
      true;  ///< false: redundant constraints admit other reactions; these belong to the least multipliers
};

/// Reactions of a scene's joints, one per solid in the scene's order.
class Reactions {
 public:
  /// Fails where compile() does.
  static Result<Reactions> of(const Scene& scene);

  /// Reactions at a state, from accelerations (nv) and multipliers (rows) in the order of the scene's
  /// compiled system. Generalised forces given beside the scene's act within their joints and are not needed.
  /// `touches` (one per contact; empty: all open) tells which contacts are closed.
  std::vector<JointReaction> at(const State& state, const Eigen::VectorXd& a,
                                const Eigen::VectorXd& multipliers, const std::vector<Touch>& touches = {});

  const std::vector<std::string>& solids() const { return system_->solids; }
  const std::vector<std::string>& parents() const { return parents_; }
  const System& system() const { return *system_; }
  /// Reactions at every row of a trajectory, into its reaction_* members.
  Result<void> add_to(Trajectory& trajectory);

 private:
  explicit Reactions(System system);
  void find_wrenches();
  void find_unique(const std::vector<Touch>& touches, std::vector<JointReaction>& out);
  void load(const Eigen::VectorXd& multipliers);

  std::shared_ptr<const System> system_;  ///< compiled with every solid its own body
  std::vector<std::string> parents_;
  Kinematics kinematics_;
  EffortSums efforts_;
  ConstraintRows rows_;
  Recursion recursion_;
  LagrangeTerms terms_;
  std::vector<Wrench<double>> wrenches_;  ///< per body, at the origin of its frame
};

/// Reactions at every row of a trajectory of `scene`, into the trajectory's reaction_* members. Refuses runs
/// of `moreau` with contacts: their rows do not hold the contact forces.
Result<void> add_reactions(const Scene& scene, Trajectory& trajectory);

}  // namespace borelli
