#include "dynamics/formats/osim_joint.hpp"

#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <optional>
#include <sstream>

#include "dynamics/formats/osim_function.hpp"
#include "error/printable.hpp"

namespace borelli {

using Eigen::Vector3d;
using PartKind = GuidedPart::Kind;

struct OsimJoints::Coordinate {
  std::string name;
  const XmlElement* element = nullptr;  // null: not in the file, all standard
  double start = 0, speed = 0;
  int uses = 0;  // switches that it moves
};

struct OsimJoints::Axis {
  GuidedPart part;
  int coordinate = -1;  // -1: it stays at part.by(0)
};

namespace {

// The axes of the joints that have no functions: 'r' about, 't' along x, y or z; in the order of the
// coordinates.
const std::map<std::string, std::string, std::less<>>& plain_joints() {
  static const std::map<std::string, std::string, std::less<>> joints{
      {"WeldJoint", ""},          {"PinJoint", "rz"},           {"SliderJoint", "tx"},
      {"UniversalJoint", "rxry"}, {"GimbalJoint", "rxryrz"},    {"BallJoint", "rxryrz"},
      {"PlanarJoint", "rztxty"},  {"FreeJoint", "rxryrztxtytz"}};
  return joints;
}

Switch fixed_switch(const Pose& X) {
  Switch out;
  out.kind = Fixed{X};
  return out;
}

// The pose of a part at its function's value at 0.
Pose part_at_zero(const GuidedPart& part) {
  const double by = at(part.by, 0).value;
  if (part.kind == PartKind::rotation) return {rotation_about(part.axis, by), Vector3d::Zero()};
  return {Eigen::Matrix3d::Identity(), by * part.axis};
}

// The rates of the angles of rotations about x, y and z, from the angular velocity in the frame before them.
Vector3d angle_rates(const Vector3d& angles, const Vector3d& w) {
  Eigen::Matrix3d axes;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    axes.col(i) = R.col(i);
    R = R * rotation_about(Vector3d::Unit(i), angles[i]);
  }
  const Vector3d rates = axes.fullPivLu().solve(w);
  return rates.allFinite() ? rates : Vector3d::Zero();
}

// Translations commute: those that stay come first, then one coordinate after the other, last the one of the
// first rotation.
template <class Axes>
void gather_translations(Axes& axes, int first_rotation) {
  const auto rank = [&](const auto& axis) {
    return axis.coordinate == first_rotation && axis.coordinate >= 0 ? 1'000'000 : axis.coordinate;
  };
  const auto end = std::find_if(axes.begin(), axes.end(),
                                [](const auto& axis) { return axis.part.kind == PartKind::rotation; });
  std::stable_sort(axes.begin(), end, [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
}

}  // namespace

OsimJoints::Coordinate OsimJoints::coordinate_of(const OsimJoint& joint, std::size_t i) {
  Coordinate out;
  if (i >= joint.coordinates.size()) {
    out.name = fmt::format("{}_coord_{}", joint.name, i);  // OpenSim's own name
  } else {
    const XmlElement& e = *joint.coordinates[i];
    out.element = &e;
    out.name = e.require("name");
    if (out.name.empty()) e.refuse("has an empty name; give it a name");
    for (const auto& [child, to] :
         {std::pair{"default_value", &out.start}, {"default_speed_value", &out.speed}})
      if (const XmlElement* given = e.child(child)) *to = given->content_numbers(1, 1)[0];
    for (const char* child : {"motion_type", "range", "is_free_to_satisfy_constraints", "initial_value"})
      e.child(child);
  }
  const auto [at, is_new] = joint_of_coordinate_.emplace(out.name, joint.name);
  if (!is_new)
    (out.element ? *out.element : *joint.element)
        .refuse(fmt::format("joint '{}' also has a coordinate '{}'; rename one of them",
                            printable(at->second), printable(out.name)));
  return out;
}

OsimJoints::Axis OsimJoints::custom_axis(const OsimJoint& joint, const XmlElement* element, int number,
                                         const std::vector<Coordinate>& coordinates) const {
  Axis axis;
  axis.part = {number < 3 ? PartKind::translation : PartKind::rotation, Vector3d::Unit(number % 3),
               constant(0)};
  if (!element) return axis;
  element->read = true;
  axis.part.axis = osim_vector(*element, "axis", axis.part.axis);
  if (!(axis.part.axis.norm() > 1e-12)) element->refuse("its axis has no direction");
  axis.part.axis.normalize();
  std::istringstream names(osim_text(*element, "coordinates"));
  std::string name, second;
  names >> name >> second;
  if (!second.empty())
    element->refuse(fmt::format("depends on several coordinates, '{}' and '{}'; expected one",
                                printable(name), printable(second)));
  const XmlElement* function = osim_function_in(*element);
  if (!name.empty()) {
    const auto found = std::find_if(coordinates.begin(), coordinates.end(),
                                    [&](const Coordinate& c) { return c.name == name; });
    if (found == coordinates.end())
      element->refuse(
          fmt::format("no coordinate of joint '{}' is named '{}'", printable(joint.name), printable(name)));
    axis.coordinate = int(found - coordinates.begin());
  }
  if (function)
    axis.part.by = read_osim_function(*function);
  else if (axis.coordinate >= 0)
    axis.part.by = linear(0, 1);
  const auto* polynomial = std::get_if<Polynomial>(&axis.part.by);
  if (polynomial && at(axis.part.by, 0).rate == 0 && is_line(axis.part.by)) axis.coordinate = -1;
  return axis;
}

std::vector<OsimJoints::Axis> OsimJoints::custom_axes(const OsimJoint& joint,
                                                      const std::vector<Coordinate>& coordinates) {
  const XmlElement& transform = joint.element->require_child("SpatialTransform");
  static constexpr const char* names[] = {"translation1", "translation2", "translation3",
                                          "rotation1",    "rotation2",    "rotation3"};
  std::vector<Axis> out;
  for (int i = 0; i < 6; ++i) {
    const XmlElement* found = nullptr;
    for (const XmlElement& c : transform.children)
      if (c.name == "TransformAxis" && c.text("name") == names[i]) found = &c;
    out.push_back(custom_axis(joint, found, i, coordinates));
  }
  return out;
}

std::vector<OsimJoints::Axis> OsimJoints::axes_of(const OsimJoint& joint,
                                                  std::vector<Coordinate>& coordinates) {
  const std::string& type = joint.element->name;
  if (type == "CustomJoint") {
    for (std::size_t i = 0; i < joint.coordinates.size(); ++i) coordinates.push_back(coordinate_of(joint, i));
    return custom_axes(joint, coordinates);
  }
  const auto plain = plain_joints().find(type);
  if (plain == plain_joints().end())
    joint.element->refuse(fmt::format(
        "joints of type {} are not supported; expected WeldJoint, PinJoint, SliderJoint, UniversalJoint, "
        "GimbalJoint, BallJoint, PlanarJoint, FreeJoint or CustomJoint",
        printable(type)));
  const std::string& word = plain->second;
  if (joint.coordinates.size() > word.size() / 2)
    joint.element->refuse(
        fmt::format("has {} coordinates, expected {}", joint.coordinates.size(), word.size() / 2));
  std::vector<Axis> out;
  for (std::size_t i = 0; i < word.size() / 2; ++i) {
    coordinates.push_back(coordinate_of(joint, i));
    Axis axis;
    axis.part = {word[2 * i] == 'r' ? PartKind::rotation : PartKind::translation,
                 Vector3d::Unit(word[2 * i + 1] - 'x'), linear(0, 1)};
    axis.coordinate = int(i);
    out.push_back(axis);
  }
  if (type == "BallJoint" || type == "FreeJoint") {  // their speeds are the angular velocity
    const auto& c = coordinates;
    const Vector3d rates =
        angle_rates({c[0].start, c[1].start, c[2].start}, {c[0].speed, c[1].speed, c[2].speed});
    for (int i = 0; i < 3; ++i) coordinates[i].speed = rates[i];
  }
  std::stable_partition(out.begin(), out.end(),
                        [](const Axis& axis) { return axis.part.kind == PartKind::translation; });
  return out;
}

void OsimJoints::set_motion(const Coordinate& coordinate, Switch& one) {
  one.q = {coordinate.start};
  if (coordinate.speed != 0) one.v = {coordinate.speed};
  if (!coordinate.element) return;
  const XmlElement& e = *coordinate.element;
  const bool clamped = osim_flag(e, "clamped", false), locked = osim_flag(e, "locked", false);
  const XmlElement* function = e.child("prescribed_function");
  if (function) {
    for (const XmlElement& c : function->children) mark_read(c);
    if (function->children.empty()) function = nullptr;
  }
  const bool prescribed = osim_flag(e, "prescribed", false);
  if (locked) {
    one.motion = Locked{};
    one.v.clear();
  } else if (prescribed && function) {
    one.motion = Driven{{read_osim_function(function->children[0])}};
    one.q.clear();
    one.v.clear();
  } else if (clamped && e.child("range")) {
    const std::vector<double> range = e.child("range")->content_numbers(2, 2);
    if (range[0] > range[1])
      e.child("range")->refuse(fmt::format(
          "its range runs from {:g} to {:g}; expected the smaller bound first", range[0], range[1]));
    one.ranges = {{range[0], range[1]}};
    const double start = std::clamp(coordinate.start, range[0], range[1]);
    if (start == coordinate.start) return;
    notes_.motion.push_back(
        fmt::format("coordinate '{}' starts at {:g}, because {:g} lies outside its range: at {}",
                    printable(coordinate.name), start, coordinate.start, e.where()));
    one.q = {start};
  }
}

Switch OsimJoints::switch_of(const OsimJoint& joint, std::vector<GuidedPart> parts,
                             const Coordinate& coordinate) {
  Switch out;
  const TimeValue first = at(parts[0].by, 0);
  if (parts.size() == 1 && is_line(parts[0].by) && std::abs(first.rate) == 1 && first.value == 0) {
    const Vector3d axis = first.rate * parts[0].axis;
    out.kind =
        parts[0].kind == PartKind::rotation ? SwitchKind(Rotation{axis}) : SwitchKind(Translation{axis});
  } else {
    out.kind = Guided{std::move(parts)};
  }
  out.coordinate = coordinate.name;
  if (coordinate.uses == 0) {
    set_motion(coordinate, out);
    return out;
  }
  out.coordinate = fmt::format("{}.{}", coordinate.name, coordinate.uses + 1);
  out.motion = Coupled{coordinate.name, linear(0, 1)};
  notes_.other.push_back(
      fmt::format("coordinate '{}' moves two axes with another coordinate's axis between them; '{}' follows "
                  "it by a constraint: at {}",
                  printable(coordinate.name), printable(out.coordinate), joint.element->where()));
  return out;
}

std::vector<Switch> OsimJoints::read(const OsimJoint& joint) {
  joint.element->read = true;
  std::vector<Coordinate> coordinates;
  std::vector<Axis> axes = axes_of(joint, coordinates);
  const auto rotation = std::find_if(axes.begin(), axes.end(), [](const Axis& axis) {
    return axis.part.kind == PartKind::rotation && axis.coordinate >= 0;
  });
  gather_translations(axes, rotation == axes.end() ? -1 : rotation->coordinate);
  std::vector<Switch> out;
  for (std::size_t i = 0; i < axes.size();) {
    const int moves = axes[i].coordinate;
    // what stays, also the constant part of a line through the axis, is a placement
    if (moves < 0) {
      if (const Pose X = part_at_zero(axes[i].part); !X.R.isIdentity(0) || !X.p.isZero(0))
        out.push_back(fixed_switch(X));
      ++i;
      continue;
    }
    std::size_t end = i + 1;  // behind the last axis of this coordinate before one of another
    for (std::size_t next = end;
         next < axes.size() && (axes[next].coordinate < 0 || axes[next].coordinate == moves); ++next)
      if (axes[next].coordinate == moves) end = next + 1;
    std::vector<GuidedPart> parts;
    for (; i < end; ++i) {
      if (axes[i].coordinate < 0 && at(axes[i].part.by, 0).value == 0) continue;
      parts.push_back(axes[i].part);
    }
    if (parts.size() == 1 && is_line(parts[0].by)) {
      if (const double value = at(parts[0].by, 0).value; value != 0) {
        out.push_back(fixed_switch(part_at_zero(parts[0])));
        parts[0].by = linear(0, at(parts[0].by, 0).rate);
      }
    }
    out.push_back(switch_of(joint, std::move(parts), coordinates[moves]));
    ++coordinates[moves].uses;
  }
  for (const Coordinate& c : coordinates)
    if (c.uses == 0)
      notes_.other.push_back(fmt::format("coordinate '{}' of joint '{}' moves nothing: at {}",
                                         printable(c.name), printable(joint.name),
                                         c.element ? c.element->where() : joint.element->where()));
  return out;
}

std::vector<Switch> inverse_motion(std::vector<Switch> switches) {
  std::reverse(switches.begin(), switches.end());
  for (Switch& one : switches)
    std::visit(
        [](auto& kind) {
          if constexpr (requires { kind.X_AB; }) {
            kind.X_AB = kind.X_AB.inverse();
          } else if constexpr (requires { kind.parts; }) {
            std::reverse(kind.parts.begin(), kind.parts.end());
            for (GuidedPart& part : kind.parts) part.axis = -part.axis;
          } else if constexpr (requires { kind.axis; }) {
            kind.axis = -kind.axis;
          }
        },
        one.kind);
  return switches;
}

}  // namespace borelli
