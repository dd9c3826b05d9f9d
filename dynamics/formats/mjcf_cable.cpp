#include "dynamics/formats/mjcf_cable.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "dynamics/formats/mjcf_edit.hpp"
#include "dynamics/numbers/rotation_between.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int most_rods = 1000;  // (bodies nest)

Vector3d unit_or_same(const Vector3d& v) { return v.squaredNorm() < 1e-14 ? v : Vector3d(v.normalized()); }

double on_curve(const XmlElement& e, const std::string& shape, double share,
                const std::vector<double>& size) {
  if (shape == "s") return share * size[0];
  if (shape == "cos(s)") return size[1] * std::cos(std::numbers::pi * share * size[2]);
  if (shape == "sin(s)") return size[1] * std::sin(std::numbers::pi * share * size[2]);
  if (shape != "0")
    e.refuse("curve", fmt::format("curve contains '{}', expected s, cos(s), sin(s) or 0", shape));
  return 0;
}

std::vector<Vector3d> vertices_of(const XmlElement& e) {
  const auto given = e.numbers("vertex", 6, 3 * (most_rods + 1));
  const auto counts = e.numbers("count", 1, 3);
  for (std::size_t i = 1; i < counts.size(); ++i)
    if (counts[i] != 1) e.refuse("count", "a cable has one dimension; expected one count");
  std::vector<Vector3d> out;
  if (!given.empty()) {
    if (given.size() % 3) e.refuse("vertex", "vertex must contain groups of three numbers");
    if (!counts.empty() && counts[0] > 1) e.refuse("has both vertex and count; expected one of the two");
    for (std::size_t i = 0; i < given.size(); i += 3) out.emplace_back(given[i], given[i + 1], given[i + 2]);
    return out;
  }
  if (counts.empty() || counts[0] < 2 || counts[0] > most_rods + 1 || counts[0] != std::floor(counts[0]))
    e.refuse("count", fmt::format("expected a vertex list, or a count from 2 to {}", most_rods + 1));
  auto size = e.numbers("size", 1, 3);
  if (size.empty()) size = {1};
  size.resize(3, 0);
  Matrix3d turn = Matrix3d::Identity();
  if (const auto q = e.numbers("quat", 4, 4); !q.empty()) {
    const Quaternion given_turn(q[0], q[1], q[2], q[3]);
    if (given_turn.norm() < 1e-10) e.refuse("quat", "quat is zero, expected a rotation");
    turn = rotation_matrix(given_turn / given_turn.norm());
  }
  std::istringstream words(e.text("curve"));
  std::string shapes[3] = {"0", "0", "0"};
  int word_count = 0;
  for (std::string word; words >> word; ++word_count)
    if (word_count < 3) shapes[word_count] = word;
  if (word_count > 3) e.refuse("curve", "curve contains more than three functions");
  const int count = static_cast<int>(counts[0]);
  for (int i = 0; i < count; ++i) {
    const double share = double(i) / (count - 1);
    out.push_back(turn * Vector3d(on_curve(e, shapes[0], share, size), on_curve(e, shapes[1], share, size),
                                  on_curve(e, shapes[2], share, size)));
  }
  return out;
}

// The axes of each rod: x along it, y carried on without twist. The first y lies in the plane of the first
// bend. A chain that begins straight has no such plane, so each rod takes the shortest rotation from x.
std::vector<Matrix3d> frames_of(const std::vector<Vector3d>& vertices) {
  std::vector<Matrix3d> out;
  Vector3d normal(0, 1, 0);
  for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
    const Vector3d along = unit_or_same(vertices[i + 1] - vertices[i]);
    if (i == 0) {
      const Vector3d next = vertices.size() > 2 ? unit_or_same(vertices[2] - vertices[1]) : along;
      normal = unit_or_same(unit_or_same(along.cross(next)).cross(along));
    } else {
      const Vector3d before = unit_or_same(vertices[i] - vertices[i - 1]), bend = before.cross(along);
      const double angle = std::atan2(bend.norm(), before.dot(along));
      if (bend.squaredNorm() >= 1e-14)
        normal = unit_or_same(rotation_about(bend.normalized(), angle) * normal);
    }
    Matrix3d& R = out.emplace_back();
    if (normal.squaredNorm() < 1e-14)
      R = rotation_between(Vector3d::UnitX(), along);
    else
      R << along, normal, along.cross(normal).normalized();
  }
  return out;
}

XmlElement geom_of(const XmlElement& composite, double length) {
  XmlElement geom = made_from(composite, "geom");
  if (const XmlElement* given = composite.child("geom")) geom.attributes = given->attributes;
  const std::string type = geom.text("type");
  if (type == "capsule" || type == "cylinder") {
    set_attribute(geom, "fromto", mjcf_numbers({0, 0, 0, length, 0, 0}));
  } else if (type == "box") {
    auto size = geom.numbers("size", 1, 3);
    size.resize(3, 0);
    size[0] = length / 2;
    set_attribute(geom, "size", mjcf_numbers(size));
    set_attribute(geom, "pos", mjcf_numbers({length / 2, 0, 0}));
  } else {
    geom.refuse(fmt::format("a cable's geom is '{}', expected cylinder, capsule or box", type));
  }
  return geom;
}

XmlElement joint_of(const XmlElement& composite, bool free) {
  XmlElement joint = made_from(composite, "joint");
  for (const XmlElement& c : composite.children) {
    if (c.name != "joint") continue;
    c.read = true;
    joint.attributes = c.attributes;
  }
  for (const char* key : {"kind", "solreffix", "solimpfix", "axis"}) remove_attribute(joint, key);
  if (free)
    for (const char* key : {"damping", "armature", "frictionloss"}) remove_attribute(joint, key);
  set_attribute(joint, "type", free ? "free" : "ball");
  return joint;
}

}  // namespace

MjcfCable make_mjcf_cable(const XmlElement& e) {
  e.read = true;
  if (const std::string type = e.require("type"); type != "cable")
    e.refuse("type", fmt::format("a composite of type '{}' is not supported; MuJoCo 3 has only cable", type));
  const std::string prefix = e.text("prefix"), initial = e.text("initial", "ball");
  const std::vector<Vector3d> vertices = vertices_of(e);
  const std::vector<Matrix3d> frames = frames_of(vertices);
  const std::size_t count = frames.size();
  const auto label = [&](const char* kind, std::size_t i) {
    return prefix + kind + (i == 0 ? "first" : i + 1 == count ? "last" : std::to_string(i));
  };
  MjcfCable out;
  for (std::size_t i = count; i-- > 0;) {  // from the last, since each contains those after it
    XmlElement body = made_from(e, "body");
    set_attribute(body, "name", label("B_", i));
    const Pose X = i == 0 ? Pose{frames[0], e.vector("offset", Vector3d::Zero()) + vertices[0]}
                          : Pose{frames[i - 1].transpose() * frames[i],
                                 Vector3d((vertices[i] - vertices[i - 1]).norm(), 0, 0)};
    set_pose(body, X);
    if (i > 0 || initial != "none") {
      XmlElement& joint = body.children.emplace_back(joint_of(e, i == 0 && initial == "free"));
      set_attribute(joint, "name", label("J_", i));
    }
    XmlElement& geom = body.children.emplace_back(geom_of(e, (vertices[i + 1] - vertices[i]).norm()));
    set_attribute(geom, "name", fmt::format("{}G{}", prefix, i));
    for (const XmlElement& c : e.children)
      if (c.name == "plugin") body.children.push_back(c);
    if (i + 1 < count) {
      XmlElement& apart = out.excludes.emplace_back(made_from(e, "exclude"));
      set_attribute(apart, "body1", label("B_", i));
      set_attribute(apart, "body2", label("B_", i + 1));
      body.children.push_back(std::move(out.body));
    }
    out.body = std::move(body);
  }
  return out;
}

}  // namespace borelli
