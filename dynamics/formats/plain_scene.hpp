// A scene reduced to what MJCF and URDF can hold: solids placed by constant poses, hinges, slides and balls,
// with springs and ranges on the joints.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/formats/omissions.hpp"
#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// A free coordinate, with the placement before it: X = before X_joint(q).
struct PlainJoint {
  enum class Kind { hinge, slide, ball };
  Kind kind = Kind::hinge;
  std::string name;  ///< of the coordinate
  Pose before;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit; of hinges and slides
  Eigen::Matrix3d own_axes =
      Eigen::Matrix3d::Identity();  ///< of a ball: the columns are the axes it counts in
  std::vector<double> q, v;         ///< at the start
  double armature = 0;
  std::optional<Range> range;  ///< of hinges and slides
  /// Springs and dampers: -stiffness q + pull - damping dq/dt. For a ball: the torque of a TorsionSpring
  /// whose rest is the quaternion `rest` of the ball.
  double stiffness = 0, damping = 0, pull = 0;
  std::optional<Quaternion> rest;

  /// X_joint at a position of 1 or 4 numbers.
  Pose displaced(const std::vector<double>& position) const;
};

/// X_PS = joints[0] joints[1] ... after.
struct PlainSolid {
  const Solid* source = nullptr;
  std::vector<PlainJoint> joints;
  Pose after;         ///< from the last joint, or the parent, to the solid
  Inertial inertial;  ///< sum of all; mass 0: none
};

struct PlainScene {
  Scene scene;                         ///< coupled switches are free, with a constraint each
  std::vector<PlainSolid> solids;      ///< depth first, children in the scene's order
  std::vector<const Effort*> efforts;  ///< those that the joints do not hold
  std::vector<const Constraint*> constraints;

  /// Null: there is no joint of this coordinate.
  const PlainJoint* joint(const std::string& coordinate) const;
};

/// The `degree` + 1 coefficients of f, the constant one first. Empty if f is no polynomial, or one of higher
/// degree.
std::optional<std::vector<double>> polynomial(const TimeFunction& f, int degree);

/// The name of the free joint that a solid's joints make: three slides along x, y and z and a ball in one
/// place, without springs and ranges. It is NAME of coordinates NAME.x or NAME_x, else the solid's. Empty:
/// they make none.
std::string free_joint_name(const PlainSolid& solid);

/// Adds to `lost` the coordinates of a free joint that are not named NAME.x, .y, .z and .turn, and so get
/// these names.
void list_renamed(const PlainSolid& solid, const std::string& free_joint, Omissions& lost);

/// Reduces a scene. Locked and driven coordinates and all switches but rotations, translations and balls
/// become fixed at their start. So do coordinates coupled by other functions than polynomials of
/// `coupling_degree`. Each is named in `lost`. Errors: those of compile().
Result<std::unique_ptr<PlainScene>> plain_scene(const Scene& scene, int coupling_degree, Omissions& lost);

}  // namespace borelli
