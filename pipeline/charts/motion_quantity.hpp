// What of a motion is asked for: places, orientations, coordinates, and how far two motions differ in them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

/// By its text:
///   `centre`                    the gravity centre of all solids that move in the scene
///   `solid:NAME`                a solid's gravity centre; `solid:NAME:x,y,z` a point of it, m, its own axes
///   `turn:NAME`                 a solid's orientation
///   `coordinate:NAME`           a joint's coordinate, or a ball's orientation
struct MotionQuantity {
  enum class Kind { centre, point, turn, coordinate };
  std::string text;
  Kind kind = Kind::centre;
  std::size_t solid = 0;                            ///< in the scene's order
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, in the solid
  std::string coordinate = {};
  bool angle = false;  ///< of a coordinate: rad, not m
  /// Of `centre`, per solid of the scene: mass, kg (none: it does not move), and centre, m, its own axes.
  std::vector<double> masses = {};
  std::vector<Eigen::Vector3d> centres = {};
};

/// Errors: a scene that does not compile, a text of another form, a solid or coordinate that the scene does
/// not have, the centre where nothing that has mass moves.
Result<MotionQuantity> parse_motion_quantity(const std::string& text, const Scene& scene);

/// The same before there is a scene: whether a text has the form, and its name is one of those that the
/// scene's solids and coordinates may have.
Result<void> check_motion_quantity(const std::string& text, const std::vector<std::string>& solids,
                                   const std::vector<std::string>& coordinates);

/// The gravity centre of every solid that has mass: what counts where nothing is said.
std::vector<MotionQuantity> all_gravity_centres(const Scene& scene);

/// By how much a quantity of two motions of one scene's solids differs at a row: lengths over `length` (m),
/// angles in rad. A coordinate that `other` does not have rests where it starts in `full`, which has all. A
/// solid that rests in `other` alone is in its centre as in that of `full`.
double quantity_difference(const MotionQuantity& quantity, const Trajectory& full, const Trajectory& other,
                           std::size_t row, double length);

}  // namespace borelli
