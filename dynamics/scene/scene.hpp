// What a user writes: solids in a tree, what acts on them, what holds them, and how to simulate it. Plain
// data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/scene/constraint.hpp"
#include "dynamics/scene/effort.hpp"
#include "dynamics/scene/settings.hpp"
#include "dynamics/scene/shape.hpp"
#include "dynamics/scene/site.hpp"
#include "dynamics/scene/switch.hpp"
#include "error/error.hpp"
#include "inertia/inertial.hpp"

namespace borelli {

/// A form in a solid, filled evenly with matter that counts in its inertia: give a density or a mass, not
/// both. With neither it is there to be seen only.
struct ShapeElement {
  Shape shape;
  std::optional<double> density;  ///< kg/m^3
  std::optional<double> mass;     ///< kg, of the whole form
};

/// A rigid solid S, placed from its parent P by a sequence of switches: X_PS = X_1 X_2 ... With no free or
/// driven switch it is welded to its parent: compile() merges the two and keeps both names and poses.
struct Solid {
  std::string name;                  ///< unique; not "world"
  std::string parent = world_name;   ///< a solid of the scene (in any order) or "world"
  std::vector<Switch> switches;      ///< from the parent outwards
  std::vector<Inertial> inertials;   ///< in the solid's frame; their sum counts; none: a massless frame
  std::vector<ShapeElement> shapes;  ///< counted as well
  int line = 0;                      ///< where it stands in Scene::file, for errors; 0: nowhere
};

/// All that gives a solid its inertia: its `inertials` and those of its `shapes`. The error names solid and
/// shape.
Result<std::vector<Inertial>> inertials_of(const Solid& solid);

/// The name of the coordinate of a solid's i-th switch: its own; else the solid's, with ".1", ".2" ... among
/// its switches with coordinates where it has several. Empty for a fixed switch.
std::string coordinate_name(const Solid& solid, std::size_t i);

/// "file:line: ", what an error about something that was read at that line begins with; "file: " where the
/// line is 0; empty where there is no file.
std::string place_in(const std::string& file, int line);

struct Scene {
  std::string name;
  std::string description;
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< m/s^2, world axes; every solid has its weight
  std::vector<Solid> solids;
  std::vector<Effort> efforts;
  std::vector<Constraint> constraints;
  SimulationSettings simulation;
  std::string file;  ///< that it was read from, for errors; empty: none

  /// place_in its file.
  std::string place(int line) const { return place_in(file, line); }
  /// Its place and "solid 'name'".
  std::string where(const Solid& solid) const;
};

}  // namespace borelli
