// The parts of scene files: directions, rotations, functions of time, and the fields of efforts and
// constraints by their names in the structs. For scene_file_read.cpp.
#pragma once

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "dynamics/formats/toml_table.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

inline constexpr double degree = std::numbers::pi / 180;

/// A name of a solid or coordinate in an effort or constraint; resolved when all solids are known.
struct Mention {
  std::string name;
  const toml::node* node = nullptr;
  std::string in_degrees = {};  ///< key of a number given in degrees
};

struct Mentions {
  std::vector<Mention> solids, coordinates;
};

/// A unit vector: "x", "-z", or a list of three numbers of length 1 within 1e-9.
Eigen::Vector3d unit_direction(const TomlTable& table, const toml::node& node, std::string_view label);

/// Four numbers (w, x, y, z) of length 1 within 1e-9.
std::vector<double> unit_quaternion(const TomlTable& table, const toml::node& node, std::string_view label);

/// A rotation as given in a file: a matrix, a quaternion, or none.
struct Turn {
  std::optional<Eigen::Matrix3d> matrix;
  std::optional<Quaternion> quaternion;

  Eigen::Matrix3d as_matrix() const;
  Quaternion as_quaternion() const;
};

/// Reads `quaternion`, `matrix`, or `axis` with `angle` or `angle_deg` of a table; without any: no rotation.
Turn read_turn(TomlTable& table);

/// Reads the kind of a shape with its sizes, `position`, and a rotation as read_turn().
Shape read_placed_form(TomlTable& table);

/// [lower, upper] times `unit`; for a ball a list of three such pairs.
std::vector<Range> read_ranges(const TomlTable& table, const toml::node& node, double unit, bool is_ball);

/// A number (constant), a list of polynomial coefficients, or a table with a kind and its fields.
TimeFunction read_time_function(const TomlTable& table, const toml::node& node, std::string_view label);

/// Fills the fields of a struct by name: T::fields(value, FieldReader(...)). Sites, lists and the field named
/// like the kind are required. Other fields keep their defaults if missing.
class FieldReader {
 public:
  /// `mentions` may be null for structs without sites.
  FieldReader(TomlTable& table, std::string_view kind, Mentions* mentions)
      : table_(table), kind_(kind), mentions_(mentions) {}

  void operator()(std::string_view key, double& field);
  void operator()(std::string_view key, Eigen::Vector3d& field);
  void operator()(std::string_view key, std::optional<double>& field);
  void operator()(std::string_view key, std::vector<double>& field);
  void operator()(std::string_view key, SolidPoint& field);
  void operator()(std::string_view key, SolidName& field);
  void operator()(std::string_view key, CoordinateName& field);
  void operator()(std::string_view key, AnyCoordinate& field);
  void operator()(std::string_view key, std::vector<CoordinateName>& field);
  void operator()(std::string_view key, std::optional<SolidPoint>& field);
  void operator()(std::string_view key, std::optional<SolidName>& field);
  void operator()(std::string_view key, Axes& field);
  void operator()(std::string_view key, SplineEnds& field);
  void operator()(std::string_view key, std::vector<Eigen::Vector3d>& field);
  void operator()(std::string_view key, bool& field);
  void operator()(std::string_view key, TimeFunction& field);
  void operator()(std::string_view key, std::vector<TimeFunction>& field);
  void operator()(std::string_view key, std::vector<Range>& field);
  void operator()(std::string_view key, Pose& field);
  void operator()(std::string_view key, Shape& field);

 private:
  const toml::node* get(std::string_view key);
  const toml::node* in_degrees(std::string_view key);
  void must_be_angle(std::string_view key);
  std::string solid(const toml::node& node, std::string_view label);
  CoordinateName coordinate(const toml::node& node, std::string_view label);
  SolidPoint point(const toml::node& node, std::string_view label);

  TomlTable& table_;
  std::string_view kind_;
  Mentions* mentions_;
};

/// Reads the alternative of a variant that `kind` names, with its fields; finishes the table. Refuses an
/// unknown kind.
template <class Variant, std::size_t i = 0>
Variant read_kind(TomlTable& table, const std::string& kind, Mentions* mentions,
                  std::vector<std::string_view> known = {}) {
  if constexpr (i == std::variant_size_v<Variant>) {
    table.refuse(table.require("kind"),
                 fmt::format("there is no kind named \"{}\"; known: {}", kind, fmt::join(known, ", ")));
  } else {
    using T = std::variant_alternative_t<i, Variant>;
    if constexpr (!IsCode<T>) {
      if (kind == T::kind) {
        T value;
        T::fields(value, FieldReader(table, T::kind, mentions));
        table.finish();
        return value;
      }
      known.push_back(T::kind);
    }
    return read_kind<Variant, i + 1>(table, kind, mentions, std::move(known));
  }
}

}  // namespace borelli
