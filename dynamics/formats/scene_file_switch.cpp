#include "dynamics/formats/scene_file_switch.hpp"

#include <fmt/core.h>

#include <array>
#include <iterator>

#include "dynamics/formats/scene_fields.hpp"
#include "dynamics/system/switch_check.hpp"

namespace borelli {
namespace {

// Fills the fields of a switch: a direction under the key of the kind, the others under their names.
struct SwitchReader {
  TomlTable& table;
  const toml::node& node;
  std::string_view kind;

  void operator()(std::string_view key, Eigen::Vector3d& field) const {
    field = is_direction(key) ? unit_direction(table, node, kind) : table.vector3(table.require(key), key);
  }
  void operator()(std::string_view key, double& field) const {
    field = table.number(table.require(key), key);
  }
};

// A guided switch: [{rotation = "z", by = FUNCTION}, {translation = "x", by = FUNCTION}, ...].
void read_guided(TomlTable& table, const toml::node& node, Guided& guided) {
  for (const toml::node& one : table.list(node, Guided::kind)) {
    TomlTable inner = table.table(one, fmt::format("{}, a part of {}", table.what(), Guided::kind));
    GuidedPart part;
    const std::string_view kind = inner.one_of({std::begin(guided_part_names), std::end(guided_part_names)});
    part.kind = kind == guided_part_names[0] ? GuidedPart::Kind::rotation : GuidedPart::Kind::translation;
    part.axis = unit_direction(inner, inner.require(kind), kind);
    part.by = read_time_function(inner, inner.require("by"), "by");
    inner.finish();
    guided.parts.push_back(std::move(part));
  }
  if (guided.parts.empty()) table.refuse(node, "guided is empty, expected at least one part");
}

// Reads the value under the key of the kind: an axis, `true`, or for a fixed switch its position (its
// rotation has keys of its own).
template <class T>
void read_switch_kind(TomlTable& table, const toml::node& node, T& kind) {
  if constexpr (std::is_same_v<T, Fixed>) {
    kind.X_AB.p = table.vector3(node, T::kind);
    kind.X_AB.R = read_turn(table).as_matrix();
  } else if constexpr (std::is_same_v<T, Guided>) {
    read_guided(table, node, kind);
  } else {
    if constexpr (!requires { kind.axis; })
      if (!table.boolean(node, T::kind))
        table.refuse(node, fmt::format("{} is false, expected true", T::kind));
    T::fields(kind, SwitchReader{table, node, T::kind});
  }
}

// The switch kind that `key` names.
template <std::size_t... i>
SwitchKind read_switch_kind(TomlTable& table, std::string_view key, std::index_sequence<i...>) {
  SwitchKind out;
  const auto attempt = [&]<class T>(T value) {
    if (key != T::kind) return;
    read_switch_kind(table, table.require(key), value);
    out = value;
  };
  (attempt(std::variant_alternative_t<i, SwitchKind>{}), ...);
  return out;
}

using SwitchKinds = std::make_index_sequence<std::variant_size_v<SwitchKind>>;

template <std::size_t... i>
std::vector<std::string_view> kind_names(std::index_sequence<i...>) {
  return {std::variant_alternative_t<i, SwitchKind>::kind...};
}

// The value under `key` (SI) or `key`_deg (degrees), and its factor to SI; null: neither.
std::pair<const toml::node*, double> find_in_units(TomlTable& table, std::string_view key,
                                                   bool may_be_degrees) {
  const toml::node* node = table.find(key);
  const toml::node* in_degrees = may_be_degrees ? table.find(fmt::format("{}_deg", key)) : nullptr;
  if (node && in_degrees)
    table.refuse(*in_degrees, fmt::format("has {0} and {0}_deg, expected one of them", key));
  if (in_degrees) return {in_degrees, degree};
  return {node, 1};
}

// `count` numbers under `key` or `key`_deg (a single one without a list); empty if missing.
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
  const toml::node *locked = table.find("locked"), *driven = table.find("driven"),
                   *coupled = table.find("coupled");
  if (locked && driven) table.refuse(*driven, "is locked and driven, expected one of them");
  if (coupled && (locked || driven))
    table.refuse(*coupled, "is coupled, and locked or driven, expected one of them");
  if (coupled) {
    if (is_ball)
      table.refuse(*coupled, "has three velocities and cannot be coupled; expected a switch with one");
    TomlTable inner = table.table(*coupled, fmt::format("{}, coupled", table.what()));
    Coupled out{inner.name(inner.require("to"), "to"), {}};
    out.function = read_time_function(inner, inner.require("function"), "function");
    inner.finish();
    return out;
  }
  if (locked && table.boolean(*locked, "locked")) return Locked{};
  if (!driven) return Free{};
  if (!is_ball) return Driven{{read_time_function(table, *driven, "driven")}};
  const toml::array& parts = table.list(*driven, "driven");
  if (parts.size() != 3)
    table.refuse(*driven, fmt::format("driven is a list of {}, expected three functions of time, one per "
                                      "component of its rotation vector",
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

// A short form stands for a sequence of switches.
struct ShortForm {
  std::string_view name;
  std::vector<SwitchKind> (*kinds)(const TomlTable& table, const toml::node& node);
};

std::vector<SwitchKind> universal(const TomlTable& table, const toml::node& node) {
  const toml::array& axes = table.list(node, "universal");
  if (axes.size() != 2)
    table.refuse(node, fmt::format("universal is a list of {}, expected two axes", axes.size()));
  return {Rotation{unit_direction(table, axes[0], "universal")},
          Rotation{unit_direction(table, axes[1], "universal")}};
}

std::vector<SwitchKind> cylindrical(const TomlTable& table, const toml::node& node) {
  const Eigen::Vector3d axis = unit_direction(table, node, "cylindrical");
  return {Translation{axis}, Rotation{axis}};
}

std::vector<SwitchKind> planar(const TomlTable& table, const toml::node& node) {
  const Eigen::Vector3d normal = unit_direction(table, node, "planar");
  // a normal along z gives translations along x and y; the other axes follow cyclically
  Eigen::Index up;
  normal.cwiseAbs().maxCoeff(&up);
  const Eigen::Vector3d next = Eigen::Vector3d::Unit((up + 1) % 3);
  const Eigen::Vector3d first = (next - normal.dot(next) * normal).normalized();
  return {Translation{first}, Translation{normal.cross(first)}, Rotation{normal}};
}

std::vector<SwitchKind> free_in_space(const TomlTable& table, const toml::node& node) {
  if (!table.boolean(node, "free")) table.refuse(node, "free is false, expected true");
  return {Translation{Eigen::Vector3d::UnitX()}, Translation{Eigen::Vector3d::UnitY()},
          Translation{Eigen::Vector3d::UnitZ()}, Ball{}};
}

const ShortForm short_forms[] = {
    {"universal", universal}, {"cylindrical", cylindrical}, {"planar", planar}, {"free", free_in_space}};

// The switches of a short form; their coordinates are its name and a number from 1.
std::vector<Switch> read_short_form(TomlTable& table, const ShortForm& form) {
  std::vector<Switch> out;
  std::string name;
  if (const toml::node* node = table.find("name")) name = table.name(*node, "name");
  std::size_t nq = 0, nv = 0;
  for (const SwitchKind& kind : form.kinds(table, table.require(form.name))) {
    Switch& one = out.emplace_back();
    one.kind = kind;
    if (!name.empty()) one.coordinate = fmt::format("{}.{}", name, out.size());
    std::visit([&](const auto& k) { nq += k.nq, nv += k.nv; }, kind);
  }
  const auto share = [&](std::string_view key, std::size_t count, auto member, auto size) {
    const toml::node* node = table.find(key);
    if (!node) return;
    const std::vector<double> all = table.numbers(*node, key, count);
    auto next = all.begin();
    for (Switch& one : out) {
      const auto end = next + std::visit(size, one.kind);
      (one.*member).assign(next, end);
      next = end;
    }
  };
  share("value", nq, &Switch::q, [](const auto& k) { return k.nq; });
  share("velocity", nv, &Switch::v, [](const auto& k) { return k.nv; });
  table.finish();
  return out;
}

Switch read_elementary(TomlTable& table, std::string_view key) {
  Switch out;
  out.kind = read_switch_kind(table, key, SwitchKinds{});
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
    table.refuse(*table.find("armature"), fmt::format("armature is {}, expected 0 or more", out.armature));
  out.motion = read_motion(table, is_ball);
  out.ranges = read_ranges(table, is_ball, rotates);
  table.finish();
  if (!out.v.empty() && !std::holds_alternative<Free>(out.motion))
    table.refuse("has a velocity, which only a free coordinate may have");
  if (!out.q.empty() && !is_ball && std::holds_alternative<Driven>(out.motion))
    table.refuse("has a value, but a driven coordinate takes the value of its function");
  if (!out.q.empty() && std::holds_alternative<Coupled>(out.motion))
    table.refuse("has a value, but a coupled coordinate takes the value of its function");
  // the other coordinate determines the start of a coupled one
  if (out.ranges.empty() || std::holds_alternative<Coupled>(out.motion)) return out;
  std::vector<double> start = out.q;
  if (start.empty()) start = is_ball ? std::vector<double>{1, 0, 0, 0} : std::vector<double>{0};
  if (const auto fine = check_ranges(out, start, table.what()); !fine)
    table.refuse(*find_in_units(table, "range", rotates).first, fine.error().what);
  return out;
}

}  // namespace

std::vector<Switch> read_switches(TomlTable& table) {
  std::vector<std::string_view> keys = kind_names(SwitchKinds{});
  for (const ShortForm& form : short_forms) keys.push_back(form.name);
  const std::string_view key = table.one_of(keys);
  for (const ShortForm& form : short_forms)
    if (key == form.name) return read_short_form(table, form);
  return {read_elementary(table, key)};
}

}  // namespace borelli
