#include "dynamics/formats/scene_fields.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Tolerance of unit vectors and rotations: the rounding of ten written digits.
constexpr double unit_tolerance = 1e-9;

// "x", "-z" or a list of three numbers.
Vector3d direction(const TomlTable& table, const toml::node& node, std::string_view label) {
  if (!node.is_string()) return table.vector3(node, label);
  const std::string text = table.text(node, label);
  const bool negative = text.starts_with('-');
  const std::string letter = text.substr(negative ? 1 : 0);
  if (letter != "x" && letter != "y" && letter != "z")
    table.refuse(node, fmt::format("{} is \"{}\", expected \"x\", \"y\", \"z\", one of them with a minus, or "
                                   "a list of three numbers",
                                   label, text));
  return (negative ? -1. : 1.) * Vector3d::Unit(letter[0] - 'x');
}

Matrix3d rotation_matrix_of(const TomlTable& table, const toml::node& node) {
  const toml::array& rows = table.list(node, "matrix");
  if (rows.size() != 3) table.refuse(node, "matrix: expected three rows of three numbers");
  Matrix3d R;
  for (int i = 0; i < 3; ++i) R.row(i) = table.vector3(rows[i], "a row of matrix").transpose();
  const double off = (R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off <= unit_tolerance) || R.determinant() < 0)
    table.refuse(node, fmt::format("matrix is not a rotation: R^T R differs from the identity by {:.3g}, and "
                                   "its determinant is {:.6g}",
                                   off, R.determinant()));
  return R;
}

Form read_form(TomlTable& table) {
  const std::string kind = table.text(table.require("kind"), "kind");
  const auto size = [&](std::string_view key) { return table.number(table.require(key), key); };
  const auto sizes = [&](std::string_view key) { return table.vector3(table.require(key), key); };
  if (kind == "box") return Box{sizes("size")};
  if (kind == "sphere") return Sphere{size("radius")};
  if (kind == "ellipsoid") return Ellipsoid{sizes("radii")};
  if (kind == "cylinder") return Cylinder{size("radius"), size("length")};
  if (kind == "cone") return Cone{size("radius"), size("length")};
  if (kind == "capsule") return Capsule{size("radius"), size("length")};
  if (kind != "mesh")
    table.refuse(
        table.require("kind"),
        fmt::format(
            "there is no shape named \"{}\"; known: box, sphere, ellipsoid, cylinder, cone, capsule, mesh",
            kind));
  ClosedMesh mesh;
  for (const toml::node& p : table.list(table.require("vertices"), "vertices"))
    mesh.vertices.push_back(table.vector3(p, "a vertex"));
  for (const toml::node& t : table.list(table.require("triangles"), "triangles")) {
    const std::vector<double> corners = table.numbers(t, "a triangle", 3);
    std::array<int, 3> triangle{};
    for (int k = 0; k < 3; ++k) {
      if (!(corners[k] >= 0 && corners[k] < static_cast<double>(mesh.vertices.size())) ||
          corners[k] != std::floor(corners[k]))
        table.refuse(t, fmt::format("a triangle refers to vertex {}; vertices run from 0 to {}", corners[k],
                                    static_cast<long>(mesh.vertices.size()) - 1));
      triangle[k] = static_cast<int>(corners[k]);
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace

Vector3d unit_direction(const TomlTable& table, const toml::node& node, std::string_view label) {
  const Vector3d axis = direction(table, node, label);
  const double length = axis.norm();
  if (length == 0) table.refuse(node, fmt::format("{} has length 0, expected a unit vector", label));
  if (!(std::abs(length - 1) <= unit_tolerance)) {
    const Vector3d unit = axis / length;
    table.refuse(node, fmt::format("{} has length {:.10g}, expected a unit vector: [{}, {}, {}]", label,
                                   length, unit[0], unit[1], unit[2]));
  }
  return axis;
}

std::vector<double> unit_quaternion(const TomlTable& table, const toml::node& node, std::string_view label) {
  std::vector<double> q = table.numbers(node, label, 4);
  const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (length == 0) table.refuse(node, fmt::format("{} has length 0, expected a unit quaternion", label));
  if (!(std::abs(length - 1) <= unit_tolerance))
    table.refuse(node,
                 fmt::format("{} has length {:.10g}, expected a unit quaternion: [{}, {}, {}, {}]", label,
                             length, q[0] / length, q[1] / length, q[2] / length, q[3] / length));
  return q;
}

Matrix3d Turn::as_matrix() const {
  if (quaternion) return rotation_matrix(*quaternion);
  return matrix.value_or(Matrix3d::Identity());
}

Quaternion Turn::as_quaternion() const {
  if (quaternion) return *quaternion;
  return matrix ? borelli::quaternion(*matrix) : identity_quaternion();
}

Turn read_turn(TomlTable& table) {
  Turn turn;
  const toml::node *matrix = table.find("matrix"), *quaternion = table.find("quaternion"),
                   *axis = table.find("axis");
  const toml::node *angle = table.find("angle"), *angle_deg = table.find("angle_deg");
  if ((matrix != nullptr) + (quaternion != nullptr) + (axis != nullptr) > 1)
    table.refuse("has more than one of matrix, quaternion and axis, expected at most one");
  if (axis && !angle == !angle_deg) table.refuse("its axis needs either angle or angle_deg");
  if (!axis && (angle || angle_deg)) table.refuse("has an angle without an axis");
  if (matrix) turn.matrix = rotation_matrix_of(table, *matrix);
  if (quaternion) {
    const auto q = unit_quaternion(table, *quaternion, "quaternion");
    turn.quaternion = Quaternion(q[0], q[1], q[2], q[3]);
  }
  if (axis) {
    const double by = angle ? table.number(*angle, "angle") : degree * table.number(*angle_deg, "angle_deg");
    turn.matrix = rotation_about(unit_direction(table, *axis, "axis"), by);
  }
  return turn;
}

Shape read_placed_form(TomlTable& table) {
  Shape out;
  out.form = read_form(table);
  table.read("position", out.position);
  const Quaternion q = read_turn(table).as_quaternion();
  out.orientation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  return out;
}

std::vector<Range> read_ranges(const TomlTable& table, const toml::node& node, double unit, bool is_ball) {
  const auto one = [&](const toml::node& pair, std::string_view label) {
    const std::vector<double> bounds = table.numbers(pair, label, 2);
    return Range{bounds[0] * unit, bounds[1] * unit};
  };
  if (!is_ball) return {one(node, "range")};
  const toml::array& pairs = table.list(node, "range");
  if (pairs.size() != 3)
    table.refuse(node, fmt::format("range is a list of {}, expected three ranges [[lower, upper], ...], one "
                                   "per component of the rotation vector",
                                   pairs.size()));
  std::vector<Range> out;
  for (const toml::node& pair : pairs) out.push_back(one(pair, "one of its ranges"));
  return out;
}

TimeFunction read_time_function(const TomlTable& table, const toml::node& node, std::string_view label) {
  if (node.is_number()) return constant(table.number(node, label));
  if (node.is_table()) {
    TomlTable inner = table.table(node, fmt::format("{}, {}", table.what(), label));
    const std::string kind = inner.text(inner.require("kind"), "kind");
    TimeFunction out = read_kind<TimeFunction>(inner, kind, nullptr);
    if (auto* samples = std::get_if<Table>(&out)) samples->prepare();
    if (const std::string bad = complaint_of(out); !bad.empty()) inner.refuse(bad);
    return out;
  }
  if (!node.is_array())
    table.refuse(
        node,
        fmt::format("{} is {}, expected a number, a list of polynomial coefficients, or a table with a kind",
                    label, TomlTable::kind_of(node)));
  const std::vector<double> coefficients = table.numbers(node, label);
  if (coefficients.empty()) table.refuse(node, fmt::format("{} has no coefficients", label));
  return Polynomial{coefficients};
}

// ---- fields ----

const toml::node* FieldReader::get(std::string_view key) {
  return key == kind_ ? &table_.require(key) : table_.find(key);
}

// `rest`, `range` and `angle` may be given in degrees.
const toml::node* FieldReader::in_degrees(std::string_view key) {
  if (key != "rest" && key != "range" && key != "angle") return nullptr;
  const toml::node* node = table_.find(fmt::format("{}_deg", key));
  if (node && table_.find(key))
    table_.refuse(*node, fmt::format("has {0} and {0}_deg, expected one of them", key));
  return node;
}

void FieldReader::must_be_angle(std::string_view key) {
  if (mentions_ && !mentions_->coordinates.empty()) mentions_->coordinates.back().in_degrees = key;
}

std::string FieldReader::solid(const toml::node& node, std::string_view label) {
  const std::string name = table_.name(node, label);
  mentions_->solids.push_back({name, &node});
  return name;
}

CoordinateName FieldReader::coordinate(const toml::node& node, std::string_view label) {
  const std::string name = table_.name(node, label);
  mentions_->coordinates.push_back({name, &node});
  return {name};
}

// "thigh" (its origin), or {solid = "thigh", point = [0, 0, -0.2]}
SolidPoint FieldReader::point(const toml::node& node, std::string_view label) {
  if (node.is_string()) return {solid(node, label), Vector3d::Zero()};
  TomlTable inner = table_.table(node, fmt::format("{}, {}", table_.what(), label));
  SolidPoint out;
  if (const toml::node* name = inner.find("solid")) out.solid = solid(*name, "solid");
  inner.read("point", out.point);
  inner.finish();
  return out;
}

void FieldReader::operator()(std::string_view key, double& field) {
  if (const toml::node* node = get(key)) {
    field = table_.number(*node, key);
    // a stiffness may be negative (unstable rest position); a negative damping would add energy
    if (key == "damping" && field < 0)
      table_.refuse(*node, fmt::format("damping is {}, expected 0 or more", field));
  }
  const toml::node* node = in_degrees(key);
  if (!node) return;
  field = degree * table_.number(*node, "rest_deg");
  must_be_angle("rest_deg");
}

void FieldReader::operator()(std::string_view key, Vector3d& field) {
  if (const toml::node* node = get(key)) {
    field = is_direction(key) ? direction(table_, *node, key) : table_.vector3(*node, key);
    if (is_direction(key) && field.norm() == 0)
      table_.refuse(*node, fmt::format("{} has length 0, expected a direction", key));
  }
  if (const toml::node* node = in_degrees(key)) field = degree * table_.vector3(*node, "rest_deg");
}

void FieldReader::operator()(std::string_view key, std::optional<double>& field) {
  if (const toml::node* node = table_.find(key)) field = table_.number(*node, key);
}

void FieldReader::operator()(std::string_view key, std::vector<double>& field) {
  field = table_.numbers(table_.require(key), key);
  if (field.empty()) table_.refuse(fmt::format("{} is empty", key));
}

void FieldReader::operator()(std::string_view key, SolidPoint& field) {
  field = point(table_.require(key), key);
}

void FieldReader::operator()(std::string_view key, SolidName& field) {
  field.solid = solid(table_.require(key), key);
}

void FieldReader::operator()(std::string_view key, CoordinateName& field) {
  field = coordinate(table_.require(key), key);
}

void FieldReader::operator()(std::string_view key, AnyCoordinate& field) {
  field = {coordinate(table_.require(key), key).coordinate};
}

void FieldReader::operator()(std::string_view key, std::vector<CoordinateName>& field) {
  for (const toml::node& node : table_.list(table_.require(key), key)) field.push_back(coordinate(node, key));
  if (field.empty()) table_.refuse(fmt::format("{} is empty", key));
}

void FieldReader::operator()(std::string_view key, std::vector<Vector3d>& field) {
  for (const toml::node& node : table_.list(table_.require(key), key))
    field.push_back(table_.vector3(node, fmt::format("a point of {}", key)));
}

void FieldReader::operator()(std::string_view key, SplineEnds& field) {
  const toml::node* node = get(key);
  if (!node) return;
  const std::string text = table_.text(*node, key);
  const auto name = std::find(std::begin(spline_ends_names), std::end(spline_ends_names), text);
  if (name == std::end(spline_ends_names))
    table_.refuse(*node, fmt::format("{} is \"{}\", expected \"{}\"", key, text,
                                     fmt::join(spline_ends_names, "\", \"")));
  field = static_cast<SplineEnds>(name - std::begin(spline_ends_names));
}

void FieldReader::operator()(std::string_view key, std::optional<SolidPoint>& field) {
  if (const toml::node* node = table_.find(key)) field = point(*node, key);
}

void FieldReader::operator()(std::string_view key, std::optional<SolidName>& field) {
  if (const toml::node* node = table_.find(key)) field = SolidName{solid(*node, key)};
}

void FieldReader::operator()(std::string_view key, Axes& field) {
  const toml::node* node = get(key);
  if (!node) return;
  const std::string text = table_.text(*node, key);
  if (text != "world" && text != "solid")
    table_.refuse(*node, fmt::format("{} is \"{}\", expected \"world\" or \"solid\"", key, text));
  field = text == "world" ? Axes::world : Axes::solid;
}

void FieldReader::operator()(std::string_view key, bool& field) {
  if (const toml::node* node = get(key)) field = table_.boolean(*node, key);
}

void FieldReader::operator()(std::string_view key, TimeFunction& field) {
  const toml::node* degrees = in_degrees(key);
  const toml::node* node = degrees ? nullptr : get(key);
  if (node) field = read_time_function(table_, *node, key);
  if (degrees) field = constant(degree * table_.number(*degrees, fmt::format("{}_deg", key)));
}

// Whether a list holds lists or tables, not numbers.
static bool is_nested(const toml::node& node) {
  const toml::array* list = node.as_array();
  return list && !list->empty() && !list->get(0)->is_number();
}

// One function, or a list of them, whose entries are not numbers.
void FieldReader::operator()(std::string_view key, std::vector<TimeFunction>& field) {
  const toml::node* node = table_.find(key);
  if (!node) return;
  field.clear();
  if (!is_nested(*node)) {
    field.push_back(read_time_function(table_, *node, key));
    return;
  }
  for (const toml::node& part : *node->as_array()) field.push_back(read_time_function(table_, part, key));
}

void FieldReader::operator()(std::string_view key, std::vector<Range>& field) {
  if (const toml::node* node = table_.find(key)) field = read_ranges(table_, *node, 1, is_nested(*node));
  if (const toml::node* node = in_degrees(key)) {
    field = read_ranges(table_, *node, degree, is_nested(*node));
    must_be_angle(fmt::format("{}_deg", key));
  }
}

void FieldReader::operator()(std::string_view key, Shape& field) {
  TomlTable inner = table_.table(table_.require(key), fmt::format("{}, {}", table_.what(), key));
  field = read_placed_form(inner);
  inner.finish();
}

void FieldReader::operator()(std::string_view key, Pose& field) {
  const toml::node* node = get(key);
  if (!node) return;
  TomlTable pose = table_.table(*node, fmt::format("{}, {}", table_.what(), key));
  pose.read("position", field.p);
  field.R = read_turn(pose).as_matrix();
  pose.finish();
}

}  // namespace borelli
