#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <system_error>

#include "dynamics/formats/scene_fields.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/formats/scene_file_switch.hpp"
#include "dynamics/formats/toml_table.hpp"
#include "dynamics/formats/toml_text.hpp"
#include "dynamics/methods/integrator.hpp"
#include "error/printable.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// ---- inertia and shapes ----

// Diagonal [xx, yy, zz], [xx, yy, zz, xy, xz, yz], or three rows.
Matrix3d read_tensor(const TomlTable& table, const toml::node& node) {
  const toml::array& list = table.list(node, "tensor");
  Matrix3d tensor = Matrix3d::Zero();
  if (list.size() == 3 && list[0].is_array()) {
    for (int i = 0; i < 3; ++i) tensor.row(i) = table.vector3(list[i], "a row of tensor").transpose();
    return tensor;
  }
  const std::vector<double> e = table.numbers(node, "tensor");
  if (e.size() != 3 && e.size() != 6)
    table.refuse(
        node,
        fmt::format("tensor has {} numbers, expected [xx, yy, zz], [xx, yy, zz, xy, xz, yz] or three rows",
                    e.size()));
  tensor.diagonal() << e[0], e[1], e[2];
  if (e.size() == 6) {
    tensor(0, 1) = tensor(1, 0) = e[3];
    tensor(0, 2) = tensor(2, 0) = e[4];
    tensor(1, 2) = tensor(2, 1) = e[5];
  }
  return tensor;
}

Inertial read_inertial(TomlTable& table) {
  Inertial out;
  out.mass = table.number(table.require("mass"), "mass");
  table.read("centre", out.centre);
  const toml::node* tensor = table.find("tensor");
  if (!tensor)
    table.refuse(table.require("mass"),
                 "mass needs a tensor; give the tensor about the gravity centre (a point mass: [0, 0, 0]), "
                 "or give mass or density within shape");
  out.tensor = read_tensor(table, *tensor);
  if (const auto fine = check_physical(out, table.what(), Extent::may_be_bar_or_point); !fine)
    table.refuse(out.mass > 0 ? *tensor : table.require("mass"), fine.error().what);
  return out;
}

ShapeElement read_shape(TomlTable& table) {
  ShapeElement out;
  out.shape = read_placed_form(table);
  const toml::node *density = table.find("density"), *mass = table.find("mass");
  if (density && mass) table.refuse(*mass, "has a density and a mass, expected one of them");
  if (density) out.density = table.number(*density, "density");
  if (mass) out.mass = table.number(*mass, "mass");
  table.finish();
  // the shape checks sizes, density and closedness; a shape for display only is checked with mass 1
  const auto fine = density ? inertial_of_density(out.shape, *out.density)
                            : inertial_of_mass(out.shape, out.mass.value_or(1));
  if (!fine) table.refuse(fine.error().message());
  return out;
}

// ---- solids ----

// `joint_nodes`: receives the node of each switch.
Solid read_solid(TomlTable& table, std::size_t number, std::vector<const toml::node*>& joint_nodes) {
  Solid out;
  table.rename(fmt::format("solid {}", number));
  out.name = table.name(table.require("name"), "name");
  out.line = table.line();
  table.rename(fmt::format("solid '{}'", out.name));
  if (out.name == world_name) table.refuse("the name 'world' is reserved for the fixed frame");
  if (const toml::node* parent = table.find("parent")) out.parent = table.name(*parent, "parent");

  std::size_t count = 0;
  for (const toml::node* node : table.tables("joint")) {
    TomlTable inner = table.table(*node, fmt::format("{}, switch {} of its joint", table.what(), ++count));
    for (Switch& one : read_switches(inner)) {
      out.switches.push_back(std::move(one));
      joint_nodes.push_back(node);
    }
  }
  const toml::node *mass = table.find("mass"), *centre = table.find("centre"), *tensor = table.find("tensor");
  if (mass) out.inertials.push_back(read_inertial(table));
  if (!mass && (centre || tensor)) table.refuse(centre ? *centre : *tensor, "mass is missing");
  count = 0;
  for (const toml::node* node : table.tables("inertial")) {
    if (mass) table.refuse(*node, "has mass and inertial, expected one of them");
    TomlTable inner = table.table(*node, fmt::format("{}, inertial {}", table.what(), ++count));
    out.inertials.push_back(read_inertial(inner));
    inner.finish();
  }
  count = 0;
  for (const toml::node* node : table.tables("shape")) {
    TomlTable inner = table.table(*node, fmt::format("{}, shape {}", table.what(), ++count));
    out.shapes.push_back(read_shape(inner));
  }
  table.finish();
  return out;
}

SimulationSettings read_simulation(TomlTable& table) {
  SimulationSettings s;
  const auto positive = [&](std::string_view key, double& value) {
    table.read(key, value);
    if (!(value > 0))
      table.refuse(table.require(key), fmt::format("{} is {}, expected a positive number", key, value));
  };
  const auto not_negative = [&](std::string_view key, double& value) {
    table.read(key, value);
    if (!(value >= 0))
      table.refuse(table.require(key), fmt::format("{} is {}, expected 0 or more", key, value));
  };
  positive("end_time", s.end_time);
  if (const toml::node* node = table.find("method")) {
    s.method = table.text(*node, "method");
    const std::vector<std::string> known = integrator_names();
    if (std::find(known.begin(), known.end(), s.method) == known.end())
      table.refuse(*node,
                   fmt::format("method is \"{}\", expected one of {}", s.method, fmt::join(known, ", ")));
  }
  positive("step", s.step);
  positive("tolerance", s.tolerance);
  not_negative("accuracy", s.accuracy);
  for (const std::string_view chosen : {"method", "tolerance"})
    if (const toml::node* node = table.find(chosen); node && s.accuracy > 0)
      table.refuse(
          *node, fmt::format("{} has no effect with accuracy, which chooses it; remove one of them", chosen));
  if (const toml::node* node = table.find("verify")) s.verify = table.boolean(*node, "verify");
  not_negative("spectral_radius", s.spectral_radius);
  if (s.spectral_radius > 1)
    table.refuse(table.require("spectral_radius"),
                 fmt::format("spectral_radius is {}, expected 0 to 1", s.spectral_radius));
  not_negative("output_interval", s.output_interval);
  if (const toml::node* node = table.find("equations")) {
    const std::string text = table.text(*node, "equations");
    if (text != "recursive" && text != "lagrange")
      table.refuse(*node, fmt::format("equations is \"{}\", expected \"recursive\" or \"lagrange\"", text));
    s.equations = text == "lagrange" ? Equations::lagrange : Equations::recursive;
  }
  if (const toml::node* node = table.find("constraints")) {
    const std::string text = table.text(*node, "constraints");
    if (text != "projection" && text != "baumgarte")
      table.refuse(*node,
                   fmt::format("constraints is \"{}\", expected \"projection\" or \"baumgarte\"", text));
    s.constraints = text == "baumgarte" ? ConstraintTreatment::baumgarte : ConstraintTreatment::projection;
  }
  not_negative("baumgarte_alpha", s.baumgarte_alpha);
  not_negative("baumgarte_beta", s.baumgarte_beta);
  not_negative("energy_threshold", s.energy_threshold);
  // which of two words a key holds: true for the second
  const auto second_of = [&](std::string_view key, std::string_view first, std::string_view second) {
    const toml::node* node = table.find(key);
    if (!node) return false;
    const std::string text = table.text(*node, key);
    if (text != first && text != second)
      table.refuse(*node, fmt::format("{} is \"{}\", expected \"{}\" or \"{}\"", key, text, first, second));
    return text == second;
  };
  if (second_of("impacts", "sequential", "simultaneous")) s.impacts = ImpactLaw::simultaneous;
  if (second_of("restitution", "newton", "poisson")) s.restitution = RestitutionLaw::poisson;
  positive("rest_speed", s.rest_speed);
  s.put_apart = second_of("overlaps", "refuse", "put_apart");
  table.finish();
  return s;
}

// ---- names ----

// Names of one sort (solids, coordinates ...); each must be unique.
class GivenNames {
 public:
  explicit GivenNames(std::string sort) : sort_(std::move(sort)) {}

  void add(const TomlTable& table, const std::string& name, const toml::node& node) {
    const auto [it, is_new] = first_.emplace(name, &node);
    if (!is_new)
      table.refuse(node, fmt::format("there are two {}s named '{}'; the first is at {}", sort_, name,
                                     table.where(*it->second)));
  }
  bool has(const std::string& name) const { return first_.contains(name); }
  std::string list() const {
    std::vector<std::string> names;
    for (const auto& [name, node] : first_) names.push_back(name);
    return name_list(names);
  }

 private:
  std::string sort_;
  std::map<std::string, const toml::node*> first_;
};

// Following parents must lead to the world.
void check_circles(const TomlTable& root, const Scene& scene, const std::vector<const toml::node*>& nodes) {
  std::map<std::string, std::size_t> number;
  for (std::size_t i = 0; i < scene.solids.size(); ++i) number[scene.solids[i].name] = i;
  std::vector<int> seen(scene.solids.size(), -1);  // per solid: the start of the last walk through it
  for (std::size_t start = 0; start < scene.solids.size(); ++start)
    for (std::string name = scene.solids[start].name; name != world_name;) {
      const std::size_t at = number.at(name);
      if (seen[at] == static_cast<int>(start)) {
        std::string circle = name;
        for (std::string next = scene.solids[at].parent;; next = scene.solids[number.at(next)].parent) {
          circle += " -> " + next;
          if (next == name) break;
        }
        root.refuse(*nodes[at], fmt::format("the parents of '{}' form a loop: {}", name, circle));
      }
      if (seen[at] >= 0) break;
      seen[at] = static_cast<int>(start);
      name = scene.solids[at].parent;
    }
}

class SceneReader {
 public:
  SceneReader(const toml::table& root, const std::string& file) : root_(root, file, "") {
    scene_.file = file;
  }

  Scene read() {
    root_.read("name", scene_.name);
    root_.read("description", scene_.description);
    root_.read("gravity", scene_.gravity);
    if (const toml::node* node = root_.find("simulation")) {
      TomlTable table = root_.table(*node, "simulation");
      scene_.simulation = read_simulation(table);
    }
    for (const toml::node* node : root_.tables("solid")) read_one_solid(*node);
    scene_.efforts = read_actions<Effort>("effort");
    scene_.constraints = read_actions<Constraint>("constraint");
    read_markers();
    root_.finish();
    check_names();
    return std::move(scene_);
  }

 private:
  void read_one_solid(const toml::node& node) {
    TomlTable table = root_.table(node, "solid");
    std::vector<const toml::node*> joint_nodes;
    scene_.solids.push_back(read_solid(table, scene_.solids.size() + 1, joint_nodes));
    const Solid& solid = scene_.solids.back();
    solids_.add(root_, solid.name, table.require("name"));
    solid_nodes_.push_back(&node);
    if (const toml::node* parent = table.find("parent")) parents_.push_back({solid.parent, parent});
    for (std::size_t i = 0; i < solid.switches.size(); ++i) {
      const Switch& s = solid.switches[i];
      const std::string coordinate = coordinate_name(solid, i);
      if (coordinate.empty()) continue;
      const toml::node* name = joint_nodes[i]->as_table()->get("name");
      coordinates_.add(root_, coordinate, name ? *name : *joint_nodes[i]);
      if (const auto* coupled = std::get_if<Coupled>(&s.motion))
        mentions_.coordinates.push_back({coupled->to, joint_nodes[i]->as_table()->get("coupled")});
      is_angle_[coordinate] = std::visit([](const auto& kind) { return kind.rotates; }, s.kind);
    }
  }

  template <class Action>
  std::vector<Action> read_actions(const std::string& key) {
    std::vector<Action> out;
    GivenNames names(key);
    for (const toml::node* node : root_.tables(key)) {
      TomlTable table = root_.table(*node, fmt::format("{} {}", key, out.size() + 1));
      Action action;
      const toml::node& name = table.require("name");
      action.name = table.name(name, "name");
      action.line = table.line();
      names.add(root_, action.name, name);
      table.rename(fmt::format("{} '{}'", key, action.name));
      const std::string kind = table.text(table.require("kind"), "kind");
      action.kind = read_kind<decltype(action.kind)>(table, kind, &mentions_);
      out.push_back(std::move(action));
    }
    return out;
  }

  void read_markers() {
    GivenNames names("marker");
    for (const toml::node* node : root_.tables("marker")) {
      TomlTable table = root_.table(*node, fmt::format("marker {}", scene_.markers.size() + 1));
      Marker marker;
      const toml::node &name = table.require("name"), &solid = table.require("solid");
      marker.name = table.name(name, "name");
      marker.line = table.line();
      names.add(root_, marker.name, name);
      table.rename(fmt::format("marker '{}'", marker.name));
      marker.at.solid = table.name(solid, "solid");
      mentions_.solids.push_back({marker.at.solid, &solid});
      table.read("point", marker.at.point);
      table.finish();
      scene_.markers.push_back(std::move(marker));
    }
  }

  void check_names() const {
    for (const auto& [name, node, key] : parents_)
      if (name != world_name && !solids_.has(name))
        root_.refuse(*node, fmt::format("there is no solid named '{}', expected 'world' or one of: {}", name,
                                        solids_.list()));
    check_circles(root_, scene_, solid_nodes_);
    for (const auto& [name, node, key] : mentions_.solids)
      if (name != world_name && !solids_.has(name))
        root_.refuse(*node, fmt::format("there is no solid named '{}', expected 'world' or one of: {}", name,
                                        solids_.list()));
    for (const auto& [name, node, in_degrees] : mentions_.coordinates) {
      if (!coordinates_.has(name))
        root_.refuse(*node, fmt::format("there is no coordinate named '{}', expected one of: {}", name,
                                        coordinates_.list()));
      if (!in_degrees.empty() && !is_angle_.at(name))
        root_.refuse(*node, fmt::format("{} needs a rotation, but '{}' is a translation", in_degrees, name));
    }
  }

  TomlTable root_;
  Scene scene_;
  Mentions mentions_;
  GivenNames solids_{"solid"}, coordinates_{"coordinate"};
  std::vector<Mention> parents_;
  std::vector<const toml::node*> solid_nodes_;
  std::map<std::string, bool> is_angle_;  // by coordinate
};

// The kind of a file that is not text: by its first bytes (RFC 1952, HDF5's format specification), else by a
// zero byte in its first line. Empty: a text, perhaps a damaged one.
std::string what_else(std::string_view bytes) {
  if (bytes.starts_with("\x1f\x8b")) return "a compressed file, such as a volume (.nii.gz)";
  if (bytes.starts_with("\x89HDF\r\n\x1a\n")) return "an HDF5 file, such as a trajectory";
  if (bytes.substr(0, bytes.find('\n')).find('\0') != std::string_view::npos) return "a binary file";
  return "";
}

}  // namespace

Result<Scene> parse_scene(std::string_view text, const std::string& file) {
  const auto root = parse_toml(text, file);
  if (!root) return tl::unexpected(root.error());
  try {
    return SceneReader(*root, file).read();
  } catch (const TomlRefusal& refusal) {
    return tl::unexpected(refusal.error);
  }
}

Result<Scene> read_scene(const std::filesystem::path& path) {
  const auto bytes = read_input_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string& text = *bytes;
  if (const auto other = what_else(text); !other.empty())
    return bad_use(path.string(),
                   fmt::format("is not a scene but {}; expected TOML, MJCF, URDF or OpenSim", other));
  auto scene = parse_scene(text, path.string());
  if (scene && scene->solids.empty())
    return bad_use(path.string(),
                   "contains no solid, so nothing can move; a scene needs at least one [[solid]]");
  return scene;
}

}  // namespace borelli
