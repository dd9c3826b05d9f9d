#include "dynamics/scene_file_switch.hpp"

#include <fmt/core.h>

#include <array>

#include "dynamics/scene_fields.hpp"
#include "dynamics/switch_check.hpp"

namespace borelli {
namespace {

// The value under a switch's own key: an axis, `true`, or for a fixed one its position (the turn stands
// beside it).
template <class T>
void read_switch_kind(TomlTable& table, const toml::node& node, T& kind) {
  if constexpr (std::is_same_v<T, Fixed>) {
    kind.X_AB.p = table.vector3(node, T::kind);
    kind.X_AB.R = read_turn(table).as_matrix();
  } else if constexpr (requires { kind.axis; }) {
    kind.axis = unit_direction(table, node, T::kind);
  } else {
    if (!table.boolean(node, T::kind)) table.refuse(node, fmt::format("{} is false, expected true", T::kind));
  }
}

template <std::size_t... i>
SwitchKind read_switch_kind(TomlTable& table, std::index_sequence<i...>) {
  const std::string_view key = table.one_of({std::variant_alternative_t<i, SwitchKind>::kind...});
  SwitchKind out;
  const auto attempt = [&]<class T>(T value) {
    if (key != T::kind) return;
    read_switch_kind(table, table.require(key), value);
    out = value;
  };
  (attempt(std::variant_alternative_t<i, SwitchKind>{}), ...);
  return out;
}

// What stands under `key` in SI or under `key`_deg in degrees, and by how much to multiply it; null: neither.
std::pair<const toml::node*, double> find_in_units(TomlTable& table, std::string_view key,
                                                   bool may_be_degrees) {
  const toml::node* node = table.find(key);
  const toml::node* in_degrees = may_be_degrees ? table.find(fmt::format("{}_deg", key)) : nullptr;
  if (node && in_degrees)
    table.refuse(*in_degrees, fmt::format("has {0} and {0}_deg, expected one of them", key));
  if (in_degrees) return {in_degrees, degree};
  return {node, 1};
}

// `count` numbers under `key` or `key`_deg (one stands alone, without a list); none: empty.
std::vector<double> read_coordinate(TomlTable& table, std::string_view key, std::size_t count,
                                    bool may_be_degrees) {
  const auto [given, unit] = find_in_units(table, key, may_be_degrees);
  if (!given) return {};
  std::vector<double> values =
      count == 1 ? std::vector{table.number(*given, key)} : table.numbers(*given, key, count);
  for (double& v : values) v *= unit;
  return values;
}

Motion read_motion(TomlTable& table, bool is_ball) {
  const toml::node *locked = table.find("locked"), *driven = table.find("driven");
  if (locked && driven) table.refuse(*driven, "is locked and driven, expected one of them");
  if (locked && table.boolean(*locked, "locked")) return Locked{};
  if (!driven) return Free{};
  if (!is_ball) return Driven{{read_time_function(table, *driven, "driven")}};
  const toml::array& parts = table.list(*driven, "driven");
  if (parts.size() != 3)
    table.refuse(
        *driven,
        fmt::format("driven is a list of {}, expected three functions of time, the components of the "
                    "ball's rotation vector",
                    parts.size()));
  Driven out;
  for (const toml::node& part : parts) out.functions.push_back(read_time_function(table, part, "driven"));
  return out;
}

// `range` or `range_deg`; none: empty.
std::vector<Range> read_ranges(TomlTable& table, bool is_ball, bool may_be_degrees) {
  const auto [node, unit] = find_in_units(table, "range", may_be_degrees);
  if (!node) return {};
  return borelli::read_ranges(table, *node, unit, is_ball);
}

}  // namespace

Switch read_switch(TomlTable& table) {
  Switch out;
  out.kind = read_switch_kind(table, std::make_index_sequence<std::variant_size_v<SwitchKind>>{});
  if (std::holds_alternative<Fixed>(out.kind)) {
    table.finish();
    return out;
  }
  const auto [nq, nv, rotates] = std::visit(
      [](const auto& kind) {
        return std::array<int, 3>{kind.nq, kind.nv, kind.rotates};
      },
      out.kind);
  const bool is_ball = nq != nv;
  if (const toml::node* name = table.find("name")) out.coordinate = table.name(*name, "name");
  if (is_ball) {
    if (const toml::node* value = table.find("value")) out.q = unit_quaternion(table, *value, "value");
  } else {
    out.q = read_coordinate(table, "value", 1, rotates);
  }
  out.v = read_coordinate(table, "velocity", static_cast<std::size_t>(nv), rotates);
  table.read("armature", out.armature);
  if (out.armature < 0)
    table.refuse(*table.find("armature"),
                 fmt::format("armature is {}, expected no negative number", out.armature));
  out.motion = read_motion(table, is_ball);
  out.ranges = read_ranges(table, is_ball, rotates);
  table.finish();
  if (!out.v.empty() && !std::holds_alternative<Free>(out.motion))
    table.refuse("has a velocity, which only a free coordinate may have");
  if (!out.q.empty() && !is_ball && std::holds_alternative<Driven>(out.motion))
    table.refuse("has a value, but a driven coordinate has the value of its function");
  if (out.ranges.empty()) return out;
  std::vector<double> start = out.q;
  if (start.empty()) start = is_ball ? std::vector<double>{1, 0, 0, 0} : std::vector<double>{0};
  if (const auto fine = check_ranges(out, start, table.what()); !fine)
    table.refuse(*find_in_units(table, "range", rotates).first, fine.error().what);
  return out;
}

}  // namespace borelli
