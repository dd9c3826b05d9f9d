#include "pipeline/charts/motion_quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/system/system.hpp"
#include "pipeline/charts/motion_difference.hpp"

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

const CoordinateInfo* info_of(const System& system, const std::string& name) {
  for (const auto* infos : {&system.coordinates, &system.driven})
    for (const CoordinateInfo& info : *infos)
      if (info.name == name) return &info;
  return nullptr;
}

double mass_of(const Solid& solid) {
  double mass = 0;
  const auto parts = inertials_of(solid).value();  // compile has checked them
  for (const Inertial& part : parts) mass += part.mass;
  return mass;
}

/// A coordinate's positions at a row; a driven ball's as its quaternion. Empty: not in the trajectory.
Eigen::VectorXd position_in(const Trajectory& t, const std::string& name, std::size_t row) {
  for (const CoordinateInfo& info : t.coordinates)
    if (info.name == name) return t.q.row(Eigen::Index(row)).segment(info.q_index, info.q_size);
  for (std::size_t i = 0; i < t.driven_names.size(); ++i) {
    if (t.driven_names[i] == name)
      return t.driven_positions.row(Eigen::Index(row)).segment(Eigen::Index(i), 1);
    if (t.driven_names[i] == name + "[0]")
      return exponential(
          Eigen::Vector3d(t.driven_positions.row(Eigen::Index(row)).segment(Eigen::Index(i), 3)));
  }
  return {};
}

/// A parsed text, independent of the scene.
struct Form {
  MotionQuantity::Kind kind = MotionQuantity::Kind::centre;
  std::string name = {};
  std::optional<Eigen::Vector3d> point = {};
};

Result<Form> form_of(const std::string& text) {
  if (text == "centre") return Form{};
  const auto parts = parts_of(text, ':', 3);
  const std::string& kind = parts[0];
  if (parts.size() < 2 || (kind != "solid" && kind != "turn" && kind != "coordinate") ||
      (kind != "solid" && parts.size() > 2))
    return bad_use("quantity '" + text + "'",
                   "expected centre, solid:NAME, solid:NAME:x,y,z, turn:NAME or coordinate:NAME");
  Form out{.kind = kind == "coordinate" ? MotionQuantity::Kind::coordinate
                   : kind == "turn"     ? MotionQuantity::Kind::turn
                                        : MotionQuantity::Kind::point,
           .name = parts[1]};
  if (parts.size() < 3) return out;
  out.point = point_of(parts[2]);
  if (!out.point)
    return bad_use("quantity '" + text + "'",
                   "its point must be three numbers, in metres, separated by commas");
  return out;
}

tl::unexpected<Error> no_such(const Form& form, const std::string& text) {
  return bad_use("quantity '" + text + "'", form.kind == MotionQuantity::Kind::coordinate
                                                ? "the scene has no moving coordinate of that name"
                                                : "the scene has no solid of that name");
}

}  // namespace

Result<MotionQuantity> parse_motion_quantity(const std::string& text, const Scene& scene) {
  const auto form = form_of(text);
  if (!form) return tl::unexpected(form.error());
  MotionQuantity out{.text = text, .kind = form->kind};
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  if (out.kind == MotionQuantity::Kind::centre) {
    out.centres = gravity_centres(scene);
    double all = 0;
    for (std::size_t s = 0; s < scene.solids.size(); ++s) {
      out.masses.push_back(system->solid_bodies[s] == 0 ? 0 : mass_of(scene.solids[s]));
      all += out.masses.back();
    }
    if (!(all > 0)) return bad_use("quantity 'centre'", "no solid with mass moves in the scene");
    return out;
  }
  if (out.kind == MotionQuantity::Kind::coordinate) {
    out.coordinate = form->name;
    const CoordinateInfo* info = info_of(*system, form->name);
    if (!info) return no_such(*form, text);
    out.angle = info->angle;
    return out;
  }
  const auto found = std::find_if(scene.solids.begin(), scene.solids.end(),
                                  [&](const Solid& solid) { return solid.name == form->name; });
  if (found == scene.solids.end()) return no_such(*form, text);
  out.solid = std::size_t(found - scene.solids.begin());
  out.point = form->point.value_or(gravity_centres(scene)[out.solid]);
  return out;
}

Result<void> check_motion_quantity(const std::string& text, const std::vector<std::string>& solids,
                                   const std::vector<std::string>& coordinates) {
  const auto form = form_of(text);
  if (!form) return tl::unexpected(form.error());
  if (form->kind == MotionQuantity::Kind::centre) return {};
  const auto& names = form->kind == MotionQuantity::Kind::coordinate ? coordinates : solids;
  if (std::find(names.begin(), names.end(), form->name) == names.end()) return no_such(*form, text);
  return {};
}

std::vector<MotionQuantity> all_gravity_centres(const Scene& scene) {
  std::vector<MotionQuantity> out;
  const auto centres = gravity_centres(scene);
  for (std::size_t s = 0; s < scene.solids.size(); ++s) {
    if (mass_of(scene.solids[s]) > 0)
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
    case MotionQuantity::Kind::centre: {
      Eigen::Vector3d moment = Eigen::Vector3d::Zero();
      double mass = 0;
      for (std::size_t s = 0; s < quantity.masses.size(); ++s) {
        const Eigen::Vector3d& at = quantity.centres[s];
        moment += quantity.masses[s] * (full.pose(row, s) * at - other.pose(row, s) * at);
        mass += quantity.masses[s];
      }
      return moment.norm() / mass / length;
    }
    case MotionQuantity::Kind::point:
      return poses().position / length;
    case MotionQuantity::Kind::turn:
      return poses().orientation;
    case MotionQuantity::Kind::coordinate:
      break;
  }
  const Eigen::VectorXd a = position_in(full, quantity.coordinate, row);
  Eigen::VectorXd b = position_in(other, quantity.coordinate, row);
  if (b.size() == 0) b = position_in(full, quantity.coordinate, 0);
  if (a.size() == 4)  // two quaternions of one orientation may differ in sign
    return 4 * std::asin(std::min(1., 0.5 * std::min((a - b).norm(), (a + b).norm())));
  return std::abs(a[0] - b[0]) / (quantity.angle ? 1 : length);
}

}  // namespace borelli
