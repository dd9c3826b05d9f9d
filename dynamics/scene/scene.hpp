// The description of a scene by its user, as plain data: a tree of solids, efforts, constraints, and how to
// simulate it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/scene/constraint.hpp"
#include "dynamics/scene/effort.hpp"
#include "dynamics/scene/marker.hpp"
#include "dynamics/scene/settings.hpp"
#include "dynamics/scene/shape.hpp"
#include "dynamics/scene/site.hpp"
#include "dynamics/scene/switch.hpp"
#include "error/error.hpp"
#include "inertia/inertial.hpp"

namespace borelli {

/// A shape in a solid. With a density or a mass (not both) it is homogeneous and adds to the inertia. With
/// neither it is for display only.
struct ShapeElement {
  Shape shape;
  std::optional<double> density;  ///< kg/m^3
  std::optional<double> mass;     ///< kg, of the whole shape
};

/// A rigid solid S, placed in its parent P by a sequence of switches: X_PS = X_1 X_2 ... Without a free or
/// driven switch it is welded to its parent: compile() merges the two and keeps both names and poses.
struct Solid {
  std::string name;                  ///< unique; not "world"
  std::string parent = world_name;   ///< a solid of the scene (in any order) or "world"
  std::vector<Switch> switches;      ///< from the parent outwards
  std::vector<Inertial> inertials;   ///< in the solid's frame; they add up; none: a massless frame
  std::vector<ShapeElement> shapes;  ///< those with density or mass add inertia too
  int line = 0;                      ///< line in Scene::file, for errors; 0: unknown
};

/// All inertias of a solid: its `inertials` and those of its `shapes`. Errors name solid and shape.
Result<std::vector<Inertial>> inertials_of(const Solid& solid);

/// The name of the coordinate of a solid's i-th switch: its own, else the solid's. If several switches of the
/// solid have coordinates, ".1", ".2" ... among them follows the solid's name. Empty for a fixed switch.
std::string coordinate_name(const Solid& solid, std::size_t i);

/// The prefix of an error about a line of a file: "file:line: "; "file: " if the line is 0; empty without a
/// file.
std::string place_in(const std::string& file, int line);

struct Scene {
  std::string name;
  std::string description;
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< m/s^2, world axes; acts on every solid
  std::vector<Solid> solids;
  std::vector<Effort> efforts;
  std::vector<Constraint> constraints;
  std::vector<Marker> markers;  ///< points that measurements refer to
  SimulationSettings simulation;
  std::string file;  ///< source file, for errors; empty: none

  /// place_in() with the file of the scene.
  std::string place(int line) const { return place_in(file, line); }
  /// A solid for errors: its place and "solid 'name'".
  std::string where(const Solid& solid) const;
};

}  // namespace borelli
