// References by name from efforts and constraints to what they act on. compile() resolves them once.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace borelli {

/// The name of the fixed frame: the parent of root solids. Springs and constraints may attach to it.
inline constexpr const char* world_name = "world";

/// A point fixed in a solid, in the solid's frame, m.
struct SolidPoint {
  std::string solid = world_name;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

/// A solid as a whole: its frame.
struct SolidName {
  std::string solid = world_name;
};

/// A scalar coordinate, by name.
struct CoordinateName {
  std::string coordinate;
};

/// A coordinate of any kind, by name: a scalar or a ball.
struct AnyCoordinate {
  std::string coordinate;
};

/// Kinds of efforts and constraints with user C++: no file can hold them.
template <class Kind>
concept IsCode = requires {
  Kind::is_code;
};

/// Kinds that may act between a solid and the world without naming a point of the world.
template <class Kind>
concept LeansOnWorld = IsCode<Kind> || requires {
  Kind::leans_on_world;
};

/// Whether a vector of this name is a direction: its length does not matter, and compile() makes it unit.
inline bool is_direction(std::string_view field) { return field == "normal" || field.starts_with("axis"); }

/// The axes in which the components of a vector are given.
enum class Axes { world, solid };

}  // namespace borelli
