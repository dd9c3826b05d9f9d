#include "tests/suite/body_map.hpp"

#include <algorithm>
#include <cmath>

namespace borelli::suite {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

constexpr std::size_t lower_trunk = part_label("lower_trunk");

std::string side_of(std::string_view name) {
  return name.ends_with("_left") ? "_left" : name.ends_with("_right") ? "_right" : "";
}

// The landmark that a part's axis runs to from its joint.
std::string end_of(std::string_view part) {
  const std::string side = side_of(part);
  if (part == "head") return "vertex";
  if (part == "upper_trunk") return "neck";
  if (part == "middle_trunk") return "spine_upper";
  if (part == "lower_trunk") return "spine_lower";
  if (part.starts_with("upper_arm")) return "elbow" + side;
  if (part.starts_with("forearm")) return "wrist" + side;
  if (part.starts_with("hand")) return "dactylion_3" + side;
  if (part.starts_with("thigh")) return "knee" + side;
  if (part.starts_with("shank")) return "ankle" + side;
  return "toe_tip" + side;
}

}  // namespace

Motion::Motion() {
  length.fill(1), girth.fill(1);
  turn.fill(Vector3d::Zero());
}

Shares shares_of_part(int label) {
  Shares out{};
  for (std::string_view at = parts[static_cast<std::size_t>(label)].name; at != "lower_trunk";) {
    const Part& part = parts[static_cast<std::size_t>(part_label(at))];
    out[joint_index(part.joint)] = 65535;
    at = part.parent;
  }
  return out;
}

BodyMap::BodyMap(const Landmarks& rest, const Motion& motion) : motion_(motion) {
  const auto at = [&](std::string_view name) { return rest.find(name)->second.point; };
  const auto set_part = [&](std::size_t p) {
    const Part& part = parts[p];
    pivot_[p] = part.joint.empty() ? at("mid_hip") : at(part.joint);
    Vector3d along = (at(end_of(part.name)) - pivot_[p]).normalized();
    if (is_axial(static_cast<int>(p))) along = Vector3d::UnitZ();
    stretch_[p] = motion.girth[p] * Matrix3d::Identity() +
                  (motion.length[p] - motion.girth[p]) * along * along.transpose();
    Vector3d point = pivot_[p];
    // the trunk's flesh is centred in its depth, not on the spine
    if (is_axial(static_cast<int>(p)) && part.name != "head")
      point =
          Vector3d(at("mid_hip").x(), 0.5 * (at("omphalion").y() + at("spine_lower").y()), at("mid_hip").z());
    axis_[p] = {point, along};
    const std::size_t parent = static_cast<std::size_t>(part_label(part.parent));
    moved_[p] = part.joint.empty() ? pivot_[p] : scaled(parent, pivot_[p]);
  };
  // parents first
  set_part(lower_trunk);
  pivot_[0] = moved_[0] = Vector3d::Zero(), stretch_[0].setIdentity(),
  axis_[0] = {Vector3d::Zero(), Vector3d::UnitZ()};
  for (std::size_t j = 0; j < n_joints; ++j)
    for (std::size_t p = 1; p < parts.size(); ++p)
      if (parts[p].joint == body_joints[j]) {
        set_part(p);
        behind_[j] = p, before_[j] = static_cast<std::size_t>(part_label(parts[p].parent));
        const double angle = motion.turn[j].norm();
        turn_[j] = Eigen::AngleAxisd(
            angle, angle > 0 ? Vector3d(motion.turn[j] / angle) : Vector3d(Vector3d::UnitZ()));
        full_[j] = turn_[j].toRotationMatrix();
      }
  wrist_rest_ = {at("wrist_left"), at("wrist_right")};
}

Vector3d BodyMap::push(const Vector3d& x, const Shares& shares) const {
  const auto of_part = [&](std::size_t p) -> Vector3d {
    if (motion_.fat[p] == 0) return Vector3d::Zero();
    const Vector3d d = x - axis_[p].point, radial = d - d.dot(axis_[p].along) * axis_[p].along;
    const Vector3d n = radial / std::sqrt(radial.squaredNorm() + 400);
    const bool belly = p == lower_trunk || parts[p].name == "middle_trunk";
    return motion_.fat[p] * (belly && motion_.fat[p] > 0 ? 1 + 0.5 * std::max(0.0, -n.y()) : 1) * n;
  };
  Vector3d sum = of_part(lower_trunk);
  for (std::size_t j = 0; j < n_joints; ++j)
    if (shares[j]) sum += shares[j] * share_unit * (of_part(behind_[j]) - of_part(before_[j]));
  return sum;
}

Vector3d BodyMap::operator()(const Vector3d& rest, const Shares& shares, double lift) const {
  const Vector3d x = lift > 0 ? Vector3d(rest + lift * push(rest, shares)) : rest;
  Vector3d z = scaled(lower_trunk, x);
  for (std::size_t j = 0; j < n_joints; ++j)
    if (shares[j]) z += shares[j] * share_unit * (scaled(behind_[j], x) - scaled(before_[j], x));
  for (std::size_t j = n_joints; j-- > 0;) {
    if (!shares[j]) continue;
    const std::size_t p = behind_[j];
    const std::string_view joint = body_joints[j];
    if (joint.starts_with("elbow")) {
      const std::size_t side = joint == "elbow_left" ? 0 : 1;
      if (motion_.pronation[side] != 0) {
        const Vector3d forearm = wrist_rest_[side] - pivot_[p];
        const double t = std::clamp((x - pivot_[p]).dot(forearm) / forearm.squaredNorm(), 0.0, 1.0);
        z = moved_[p] +
            Eigen::AngleAxisd(motion_.pronation[side] * t * shares[j] * share_unit, forearm.normalized()) *
                (z - moved_[p]);
      }
    }
    if (turn_[j].angle() == 0) continue;
    if (shares[j] == 65535)
      z = moved_[p] + full_[j] * (z - moved_[p]);
    else
      z = moved_[p] +
          Eigen::AngleAxisd(turn_[j].angle() * shares[j] * share_unit, turn_[j].axis()) * (z - moved_[p]);
  }
  return motion_.whole * z;
}

Vector3d BodyMap::with_part(int label, const Vector3d& rest) const {
  return (*this)(rest, shares_of_part(label), 0);
}

}  // namespace borelli::suite
