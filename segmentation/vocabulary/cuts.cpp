#include "segmentation/vocabulary/cuts.hpp"

#include <Eigen/Geometry>
#include <numbers>
#include <optional>

#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

std::optional<Vector3d> find(const Landmarks& landmarks, const std::string& name) {
  const auto it = landmarks.find(name);
  if (it == landmarks.end()) return std::nullopt;
  return it->second.point;
}

std::optional<Vector3d> mid_hip(const Landmarks& landmarks) {
  if (const auto p = find(landmarks, "mid_hip")) return p;
  const auto l = find(landmarks, "hip_left"), r = find(landmarks, "hip_right");
  if (!l || !r) return std::nullopt;
  return Vector3d(0.5 * (*l + *r));
}

// unit bisector of the directions a -> b and b -> c
Vector3d bisector(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return ((b - a).normalized() + (c - b).normalized()).normalized();
}

}  // namespace

Eigen::Matrix3d trunk_axes(const Landmarks& landmarks) {
  const auto bottom = mid_hip(landmarks), top = find(landmarks, "neck");
  const auto left_hip = find(landmarks, "hip_left"), right_hip = find(landmarks, "hip_right");
  Vector3d up = Vector3d::UnitZ(), left = Vector3d::UnitX();
  if (bottom && top) up = (*top - *bottom).normalized();
  if (left_hip && right_hip)
    left = *left_hip - *right_hip;
  else if (bottom && (left_hip || right_hip))  // one leg only
    left = left_hip ? Vector3d(*left_hip - *bottom) : Vector3d(*bottom - *right_hip);
  left = (left - left.dot(up) * up).normalized();
  Eigen::Matrix3d axes;
  axes << left, up.cross(left), up;
  return axes;
}

std::vector<Cut> cut_planes(const Landmarks& landmarks, Convention convention) {
  if (convention == Convention::bone) return {};
  const Eigen::Matrix3d axes = trunk_axes(landmarks);
  const Vector3d left = axes.col(0), up = axes.col(2);
  std::vector<Cut> cuts;

  for (std::size_t label = 1; label < parts.size(); ++label) {
    const Part& part = parts[label];
    if (part.joint.empty()) continue;
    const std::string joint(part.joint);
    const bool is_left = joint.ends_with("_left");
    const std::string side = is_left ? "_left" : "_right";
    const Vector3d lateral = is_left ? left : Vector3d(-left);
    const auto centre = find(landmarks, joint);

    std::optional<Vector3d> point, normal;
    double reach = std::numeric_limits<double>::infinity();
    if (joint == "neck") {
      point = centre, normal = up;
    } else if (joint.starts_with("spine")) {
      point = find(landmarks, bound_of(joint, convention)), normal = up;
    } else if (joint.starts_with("hip") && convention == Convention::dempster) {
      const auto knee = find(landmarks, "knee" + side);
      point = centre;
      normal = centre && knee ? bisector(*centre + up, *centre, *knee) : Vector3d(-up);
    } else if (joint.starts_with("hip")) {
      constexpr double tilt = 37 * std::numbers::pi / 180;
      if (centre) point = find(landmarks, bound_of(joint, convention));  // no joint centre: no leg
      normal = Vector3d(std::cos(tilt) * lateral - std::sin(tilt) * up);
    } else if (joint.starts_with("shoulder")) {
      if (centre) point = Vector3d(*centre - landmarks.find(joint)->second.radius * lateral);
      normal = lateral;
      // the armpit's floor lies about 2.5 radii of the humeral head below it
      if (centre) reach = 3 * landmarks.find(joint)->second.radius;
    } else {
      const bool arm = joint.starts_with("elbow") || joint.starts_with("wrist");
      const std::string before = joint.starts_with("elbow")   ? "shoulder"
                                 : joint.starts_with("wrist") ? "elbow"
                                 : joint.starts_with("knee")  ? "hip"
                                                              : "knee";
      const std::string after = joint.starts_with("elbow")   ? "wrist"
                                : joint.starts_with("wrist") ? "metacarpale_3"
                                                             : "ankle";
      const auto a = find(landmarks, before + side);
      auto c = joint.starts_with("ankle") ? std::nullopt : find(landmarks, after + side);
      if (!c && joint.starts_with("elbow")) c = find(landmarks, "forearm_end" + side);
      if (!c && joint.starts_with("knee")) c = find(landmarks, "shank_end" + side);
      point = centre;
      if (centre && a && c)
        normal = bisector(*a, *centre, *c);
      else if (centre && a && (arm || joint.starts_with("ankle")))
        normal = Vector3d((*centre - *a).normalized());
      else if (centre && c)
        normal = Vector3d((*c - *centre).normalized());
    }
    // the trunk's tree grows upwards from the lower trunk, so the "distal" part of a trunk cut is above it
    if (point && normal)
      cuts.push_back({joint, part_label(part.parent), static_cast<int>(label), *point, *normal, reach});
  }
  return cuts;
}

}  // namespace borelli
