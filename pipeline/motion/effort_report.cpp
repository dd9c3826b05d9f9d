#include "pipeline/motion/effort_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "dynamics/numbers/rotation_vector.hpp"
#include "pipeline/motion/scaled_scene.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

constexpr double to_degrees = 180 / std::numbers::pi;

/// "hip_left" as "left hip".
std::string joint_in_words(std::string joint) {
  for (const std::string side : {"left", "right"})
    if (joint.ends_with("_" + side)) joint = side + " " + joint.substr(0, joint.size() - side.size() - 1);
  std::ranges::replace(joint, '_', ' ');
  return joint;
}

template <class Column>
json numbers_of(const Column& column) {
  json out = json::array();
  for (Eigen::Index i = 0; i < column.size(); ++i) out.push_back(column[i]);
  return out;
}

json shares_of(const EffortBands& bands, Eigen::Index u) {
  double all = 0;
  for (const Rows& cause : bands.by_cause) all += cause.col(u).squaredNorm();
  json shares = json::object();
  for (std::size_t c = 0; c < bands.causes.size(); ++c)
    shares[bands.causes[c]] = all > 0 ? bands.by_cause[c].col(u).squaredNorm() / all : 0;
  return shares;
}

/// The direction in which a ball joint's rotation about an axis (0, 1, 2) is positive, as joint_axes.hpp
/// defines the axes, in the field's words; "about its axis x" for a joint that a body has not.
std::string ball_motion(std::string_view joint, int axis) {
  using Words = std::array<const char*, 3>;
  constexpr Words limb{"flexion", "adduction", "internal rotation"};
  constexpr Words trunk{"flexion", "bending to the left", "rotation to the left"};
  constexpr std::pair<std::string_view, Words> known[] = {
      {"ankle_", {"dorsiflexion", "inversion", "internal rotation"}},
      {"wrist_", {"flexion", "ulnar deviation", "pronation"}},
      {"hip_", limb},
      {"knee_", limb},
      {"shoulder_", limb},
      {"elbow_", limb},
      {"neck", trunk},
      {"spine_", trunk}};
  for (const auto& [start, words] : known)
    if (joint.starts_with(start)) return words[std::size_t(axis)];
  return std::string("about its axis ") + "xyz"[axis];
}

json coordinate_report(const CapturedMotion& motion, const System& system, const CoordinateInfo& c, int part,
                       const std::optional<EffortBands>& bands) {
  const RecordedEfforts& efforts = motion.efforts;
  const Eigen::Index u = c.v_index + part;
  std::string kind = "flexion";
  if (c.v_size == 3) {
    kind = ball_motion(c.name, part);
  }
  json angles = json::array();
  for (Eigen::Index i = 0; i < efforts.q.rows(); ++i) {
    if (c.q_size == 4) {
      const Quaternion turn = efforts.q.row(i).segment<4>(c.q_index).transpose();
      angles.push_back(logarithm(turn)[part] * to_degrees);
    } else {
      angles.push_back(efforts.q(i, c.q_index) * to_degrees);
    }
  }
  json out{{"name", system.velocity_name(int(u))},
           {"label", joint_in_words(c.name) + ", " + kind},
           {"joint", c.name},
           {"solid", c.solid},
           {"angle_deg", angles},
           {"moment", numbers_of(efforts.efforts.col(u))},
           {"power", numbers_of(efforts.powers.col(u))}};
  if (bands) {
    out["deviation"] = numbers_of(bands->deviation.col(u));
    out["shares"] = shares_of(*bands, u);
  }
  return out;
}

json force_report(const ExternalLoad& load, const std::vector<double>& times) {
  json forces = json::array(), points = json::array();
  const MeasuredForce& m = load.measured;
  for (const double t : times) {
    const auto after = std::lower_bound(m.times.begin(), m.times.end(), t - 1e-9) - m.times.begin();
    const auto at = Eigen::Index(std::min<std::ptrdiff_t>(after, std::ssize(m.times) - 1));
    const bool there = at >= 0 && m.point.col(at).allFinite() && m.force.col(at).norm() > 0;
    const Vector3d f = there ? Vector3d(m.force.col(at)) : Vector3d::Zero();
    forces.push_back({f.x(), f.y(), f.z()});
    points.push_back(there ? json{m.point(0, at), m.point(1, at), m.point(2, at)} : json());
  }
  return {{"name", m.name}, {"solid", load.body}, {"force", forces}, {"point", points}};
}

}  // namespace

json residual_report(const RecordedEfforts& efforts) {
  json out = json::array();
  for (const RootResidual& r : efforts.residuals) {
    json one{{"coordinate", r.coordinate}, {"unit", r.angle ? "N m" : "N"}, {"rms", r.rms}, {"peak", r.peak}};
    if (!r.angle && efforts.peak_force > 0) one["percent_of_peak_force"] = 100 * r.peak / efforts.peak_force;
    out.push_back(one);
  }
  return out;
}

json effort_report(const CapturedMotion& motion, const System& system,
                   const std::optional<EffortBands>& bands, const std::string& source) {
  const RecordedEfforts& efforts = motion.efforts;
  json out{{"source", source},
           {"times", efforts.times},
           {"coordinates", json::array()},
           {"residuals", residual_report(efforts)},
           {"forces", json::array()}};
  if (const auto mass = total_mass(motion.scene)) out["mass_kg"] = *mass;
  for (const CoordinateInfo& c : system.coordinates) {
    const auto solid = std::ranges::find(system.solids, c.solid) - system.solids.begin();
    const auto body = std::size_t(system.solid_bodies[std::size_t(solid)]);
    if (!c.angle || system.bodies[body].parent == 0) continue;
    for (int part = 0; part < c.v_size; ++part)
      out["coordinates"].push_back(coordinate_report(motion, system, c, part, bands));
  }
  for (const ExternalLoad& load : motion.loads) out["forces"].push_back(force_report(load, efforts.times));
  return out;
}

}  // namespace borelli
