// Names and frames in OpenSim's conventions.
#pragma once

#include <map>
#include <set>
#include <string>

#include "dynamics/formats/omissions.hpp"
#include "dynamics/numbers/pose.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

/// Gives the bodies, coordinates and other components of a scene names that OpenSim accepts: without
/// / \ * + and white space (ComponentPath.cpp), and different from each other. Keeps a name where it can.
///
/// OpenSim's ground has y up. Where the scene's gravity points along -z, its world is turned: x stays, z
/// becomes y. Other worlds stay.
class OsimNames {
 public:
  explicit OsimNames(const Scene& scene);

  const std::string& body(const std::string& solid) const { return bodies_.at(solid); }
  /// Of a scalar coordinate.
  const std::string& coordinate(const std::string& name) const { return coordinates_.at(name); }
  bool is_scalar(const std::string& name) const { return coordinates_.contains(name); }

  /// Of a solid or the world.
  std::string path(const std::string& solid) const {
    return solid == world_name ? "/ground" : "/bodyset/" + body(solid);
  }
  /// A pose in a solid or the world, in the frame that path() names.
  Pose in_frame(const std::string& solid, const Pose& X) const { return solid == world_name ? X_GW_ * X : X; }
  /// Components in the world's axes, in those of the ground.
  Eigen::Vector3d in_ground(const Eigen::Vector3d& v) const { return X_GW_.R * v; }
  Eigen::Vector3d point(const SolidPoint& at) const {
    return at.solid == world_name ? Eigen::Vector3d(X_GW_ * at.point) : at.point;
  }
  bool turns_world() const { return !X_GW_.R.isIdentity(0); }

  /// A name near this one that no body has; it is taken then.
  std::string new_body(const std::string& wanted) { return make(wanted, taken_bodies_); }
  std::string new_coordinate(const std::string& wanted) { return make(wanted, taken_coordinates_); }
  /// The same in another set, such as the joints.
  static std::string make(const std::string& wanted, std::set<std::string>& taken);

  /// Adds to `lost` the names that were changed.
  void report_renamed(Omissions& lost) const;

 private:
  std::map<std::string, std::string> bodies_, coordinates_;
  Pose X_GW_;
  std::set<std::string> taken_bodies_{"ground"}, taken_coordinates_;
};

}  // namespace borelli
