// Quantities of a motion that a user may request (points, orientations, coordinates), and their differences
// between two motions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

/// A quantity, by its text:
///   `centre`                    gravity centre of all moving solids of the scene
///   `solid:NAME`                gravity centre of a solid; `solid:NAME:x,y,z` a point, m, in its own axes
///   `turn:NAME`                 orientation of a solid
///   `coordinate:NAME`           coordinate of a joint, or orientation of a ball joint
struct MotionQuantity {
  enum class Kind { centre, point, turn, coordinate };
  std::string text;
  Kind kind = Kind::centre;
  std::size_t solid = 0;                            ///< in the scene's order
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, in the solid
  std::string coordinate = {};
  bool angle = false;  ///< the coordinate is an angle: rad, not m
  /// For `centre`, per solid of the scene: mass, kg (0: it does not move), and gravity centre, m, own axes.
  std::vector<double> masses = {};
  std::vector<Eigen::Vector3d> centres = {};
};

/// Errors: a scene that does not compile, malformed text, an unknown solid or coordinate, `centre` if nothing
/// with mass moves.
Result<MotionQuantity> parse_motion_quantity(const std::string& text, const Scene& scene);

/// Checks a text before the scene exists: its form, and whether its name is among the possible names of
/// solids and coordinates.
Result<void> check_motion_quantity(const std::string& text, const std::vector<std::string>& solids,
                                   const std::vector<std::string>& coordinates);

/// Gravity centres of all solids that have mass: the default quantities.
std::vector<MotionQuantity> all_gravity_centres(const Scene& scene);

/// Difference of a quantity between two motions of one scene's solids at a row: lengths over `length` (m),
/// angles in rad. A coordinate missing from `other` keeps its start value in `full`, which has all
/// coordinates. A solid at rest only in `other` still counts in the common centre, as in `full`.
double quantity_difference(const MotionQuantity& quantity, const Trajectory& full, const Trajectory& other,
                           std::size_t row, double length);

}  // namespace borelli
