// What joints transmit: the force and the moment that a solid has from its parent, through a joint that moves
// or is driven, locked or welded.
#pragma once

#include <memory>

#include "dynamics/equations/recursive.hpp"
#include "dynamics/scene/contact.hpp"

namespace borelli {

/// On the solid from its parent, world axes. All that goes through the joint: what its bearings hold and what
/// springs, drives, controllers, limits and couplings of its own coordinates do. (Of an armature the rotor
/// counts as outside: what turns it is not transmitted.)
struct JointReaction {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     ///< m: the origin of the frame that the joint's last
                                                       ///< moving switch leads to; of a weld, of the solid's
  Eigen::Vector3d force = Eigen::Vector3d::Zero();     ///< N
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();    ///< N m, about `point`
  Eigen::Matrix3d R_WP = Eigen::Matrix3d::Identity();  ///< the parent's axes: R_WP^T force is along them
  bool unique =
      true;  ///< false: other loads of redundant constraints would do as well; these are of the least
};

/// Finds the reactions of a scene's joints, one per solid in the scene's order.
class Reactions {
 public:
  /// Fails where compile() does.
  static Result<Reactions> of(const Scene& scene);

  /// At a state with the accelerations (nv) and multipliers (rows) that the equations give there, all in the
  /// order of the scene's compiled system; `given` generalized efforts beside the scene's act within their
  /// joints and need not be told. `touches` (one per contact, or none: all are open) say which contacts hold.
  std::vector<JointReaction> at(const State& state, const Eigen::VectorXd& a,
                                const Eigen::VectorXd& multipliers, const std::vector<Touch>& touches = {});

  const std::vector<std::string>& solids() const { return system_->solids; }
  const std::vector<std::string>& parents() const { return parents_; }
  const System& system() const { return *system_; }
  /// Those at every row of a trajectory, into Trajectory::reactions.
  Result<void> add_to(Trajectory& trajectory);

 private:
  explicit Reactions(System system);
  void find_wrenches();
  void find_unique(const std::vector<Touch>& touches, std::vector<JointReaction>& out);
  void load(const Eigen::VectorXd& multipliers);

  std::shared_ptr<const System> system_;  ///< with every solid a body of its own
  std::vector<std::string> parents_;
  Kinematics kinematics_;
  EffortSums efforts_;
  ConstraintRows rows_;
  Recursion recursion_;
  LagrangeTerms terms_;
  std::vector<Wrench<double>> wrenches_;  ///< per body, at the origin of its frame
};

/// The reactions at every row of a trajectory of that scene, into Trajectory::reactions. Refuses those of
/// `moreau` with contacts: rows hold none of their forces.
Result<void> add_reactions(const Scene& scene, Trajectory& trajectory);

}  // namespace borelli
