#include "pipeline/motion_quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "pipeline/motion_difference.hpp"

namespace borelli {
namespace {

std::vector<std::string> parts_of(const std::string& text, char between, std::size_t most) {
  std::vector<std::string> out(1);
  for (const char c : text)
    if (c == between && out.size() < most)
      out.emplace_back();
    else
      out.back() += c;
  return out;
}

std::optional<Eigen::Vector3d> point_of(const std::string& text) {
  const auto parts = parts_of(text, ',', 4);
  if (parts.size() != 3) return std::nullopt;
  Eigen::Vector3d out;
  for (int i = 0; i < 3; ++i) {
    const auto [end, problem] = std::from_chars(parts[i].data(), parts[i].data() + parts[i].size(), out[i]);
    if (problem != std::errc() || end != parts[i].data() + parts[i].size() || !std::isfinite(out[i]))
      return std::nullopt;
  }
  return out;
}

bool has_coordinate(const Scene& scene, const std::string& name) {
  for (const Solid& solid : scene.solids)
    for (std::size_t i = 0; i < solid.switches.size(); ++i)
      if (coordinate_name(solid, i) == name) return true;
  return false;
}

/// A coordinate's positions at a row; those of its start in `full` where the trajectory does not have it.
Eigen::VectorXd position_of(const std::string& name, const Trajectory& t, std::size_t row,
                            const Trajectory& full) {
  for (const auto& [from, at] : {std::pair(&t, row), std::pair(&full, std::size_t{0})})
    for (const CoordinateInfo& info : from->coordinates)
      if (info.name == name) return from->q.row(Eigen::Index(at)).segment(info.q_index, info.q_size);
  return Eigen::VectorXd::Zero(1);  // (driven or locked in both)
}

}  // namespace

Result<MotionQuantity> parse_motion_quantity(const std::string& text, const Scene& scene) {
  const auto parts = parts_of(text, ':', 3);
  const std::string& kind = parts[0];
  MotionQuantity out{.text = text};
  if (text == "centre") return out;
  if (parts.size() < 2 || (kind != "solid" && kind != "turn" && kind != "coordinate") ||
      (kind != "solid" && parts.size() > 2))
    return bad_use("quantity '" + text + "'",
                   "expected centre, solid:NAME, solid:NAME:x,y,z, turn:NAME or coordinate:NAME");
  if (kind == "coordinate") {
    out.kind = MotionQuantity::Kind::coordinate;
    out.coordinate = parts[1];
    if (!has_coordinate(scene, parts[1]))
      return bad_use("quantity '" + text + "'", "the scene has no coordinate of that name");
    return out;
  }
  out.kind = kind == "turn" ? MotionQuantity::Kind::turn : MotionQuantity::Kind::point;
  const auto found = std::find_if(scene.solids.begin(), scene.solids.end(),
                                  [&](const Solid& solid) { return solid.name == parts[1]; });
  if (found == scene.solids.end())
    return bad_use("quantity '" + text + "'", "the scene has no solid of that name");
  out.solid = std::size_t(found - scene.solids.begin());
  out.point = gravity_centres(scene)[out.solid];
  if (parts.size() == 3) {
    const auto point = point_of(parts[2]);
    if (!point)
      return bad_use("quantity '" + text + "'", "its point is not three numbers, m, with commas between");
    out.point = *point;
  }
  return out;
}

std::vector<MotionQuantity> all_gravity_centres(const Scene& scene) {
  std::vector<MotionQuantity> out;
  const auto centres = gravity_centres(scene);
  for (std::size_t s = 0; s < scene.solids.size(); ++s) {
    double mass = 0;
    const auto parts = inertials_of(scene.solids[s]).value();  // (compile has seen to them)
    for (const Inertial& part : parts) mass += part.mass;
    if (mass > 0)
      out.push_back({.text = "solid:" + scene.solids[s].name,
                     .kind = MotionQuantity::Kind::point,
                     .solid = s,
                     .point = centres[s]});
  }
  return out;
}

double quantity_difference(const MotionQuantity& quantity, const Trajectory& full, const Trajectory& other,
                           std::size_t row, double length) {
  const auto poses = [&] {
    return pose_difference(full.pose(row, quantity.solid), other.pose(row, quantity.solid), quantity.point);
  };
  switch (quantity.kind) {
    case MotionQuantity::Kind::centre:
      return (full.gravity_centre.row(Eigen::Index(row)) - other.gravity_centre.row(Eigen::Index(row)))
                 .norm() /
             length;
    case MotionQuantity::Kind::point:
      return poses().position / length;
    case MotionQuantity::Kind::turn:
      return poses().orientation;
    case MotionQuantity::Kind::coordinate:
      break;
  }
  const Eigen::VectorXd a = position_of(quantity.coordinate, full, row, full),
                        b = position_of(quantity.coordinate, other, row, full);
  if (a.size() == 4)  // two quaternions of one orientation may differ in sign
    return 4 * std::asin(std::min(1., 0.5 * std::min((a - b).norm(), (a + b).norm())));
  const bool angle = std::any_of(full.coordinates.begin(), full.coordinates.end(), [&](const auto& info) {
    return info.name == quantity.coordinate && info.angle;
  });
  return std::abs(a[0] - b[0]) / (angle ? 1 : length);
}

}  // namespace borelli
