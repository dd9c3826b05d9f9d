// How efforts and constraints name what they act on. compile() resolves the names once.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace borelli {

/// The name of the fixed frame: the parent of root solids, and what springs and constraints may hold on to.
inline constexpr const char* world_name = "world";

/// A point fixed in a solid, in the solid's frame, m.
struct SolidPoint {
  std::string solid = world_name;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

/// A whole solid (its axes).
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

/// Kinds of efforts and constraints that are a user's C++: no file can hold them.
template <class Kind>
concept IsCode = requires {
  Kind::is_code;
};

/// Kinds that may push against the world though they name no place there.
template <class Kind>
concept LeansOnWorld = IsCode<Kind> || requires {
  Kind::leans_on_world;
};

/// Whether a vector of this name is a direction: its length says nothing, and compile() makes it unit.
inline bool is_direction(std::string_view field) { return field == "normal" || field.starts_with("axis"); }

/// Whose axes a vector's components are along.
enum class Axes { world, solid };

}  // namespace borelli
