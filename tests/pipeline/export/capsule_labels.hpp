// Label maps of capsules, and a skin's motion, for the tests of skins.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "pipeline/export/skin.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli::test {

/// The points within `radius` of the segment from `top` to `bottom`, mm; without round ends: a cylinder.
struct LabelCapsule {
  std::string name;
  Eigen::Vector3d top, bottom;
  double radius;
  bool round = true;

  /// Negative inside, mm.
  double outside(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d along = bottom - top;
    const double s = (p - top).dot(along) / along.squaredNorm();
    if (!round) {
      const double across = (p - top - s * along).norm() - radius;
      return std::max({across, -s * along.norm(), (s - 1) * along.norm()});
    }
    return (p - top - std::clamp(s, 0.0, 1.0) * along).norm() - radius;
  }
};

/// Voxels of `step` mm; where capsules overlap, the first one has the voxel. Capsules of one name share a
/// label.
inline LabelMap labels_of(const std::vector<LabelCapsule>& capsules, double step) {
  LabelMap map;
  map.names = {"outside"};
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  std::vector<std::uint8_t> label;
  for (const LabelCapsule& c : capsules) {
    low = low.cwiseMin(c.top.cwiseMin(c.bottom).array().matrix() -
                       Eigen::Vector3d::Constant(c.radius + 3 * step));
    high = high.cwiseMax(c.top.cwiseMax(c.bottom) + Eigen::Vector3d::Constant(c.radius + 3 * step));
    const auto found = std::ranges::find(map.names, c.name);
    label.push_back(static_cast<std::uint8_t>(found - map.names.begin()));
    if (found == map.names.end()) map.names.push_back(c.name);
  }
  map.grid.axes *= step;
  map.grid.origin = low + Eigen::Vector3d(0.13, 0.21, 0.17) * step;  // off the shapes' symmetries
  for (int c = 0; c < 3; ++c)
    map.grid.size[static_cast<std::size_t>(c)] = static_cast<std::int64_t>((high - low)[c] / step);
  for (std::int64_t k = 0; k < map.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < map.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < map.grid.size[0]; ++i) {
        std::uint8_t here = 0;
        for (std::size_t n = 0; n < capsules.size() && !here; ++n)
          if (capsules[n].outside(map.grid.point(i, j, k)) <= 0) here = label[n];
        map.voxels.push_back(here);
      }
  return map;
}

/// Poses after joints have turned: each part by R (world axes of the scan's pose) about its joint, on top of
/// its parent's rotation. Helper bones are ignored.
inline ScanPoses turned(const std::vector<SkinJoint>& joints, const ScanPoses& X_WS,
                        const std::map<std::string, Eigen::Matrix3d>& turns) {
  std::map<std::string, Pose> moved;
  ScanPoses out;
  for (const SkinJoint& joint : joints) {
    Pose X = joint.parent.empty() ? Pose{} : moved[joint.parent];
    if (const auto turn = turns.find(joint.part); turn != turns.end()) {
      const Eigen::Vector3d c = joint.centre.value_or(Eigen::Vector3d::Zero());
      X = X * Pose{turn->second, c - turn->second * c};
    }
    moved[joint.part] = X;
    const auto rest = X_WS.find(joint.part);
    const Pose X_WS_rest = rest != X_WS.end() ? rest->second
                                              : Pose{Eigen::Matrix3d::Identity(),
                                                     joint.centre.value_or(Eigen::Vector3d::Zero())};
    out[joint.part] = X * X_WS_rest;
  }
  return out;
}

/// A rotation, degrees.
inline Eigen::Matrix3d turn_deg(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle * 3.14159265358979323846 / 180, axis.normalized()).toRotationMatrix();
}

/// A trunk with two arms that hang beside it. The left arm stays 5 mm away; the right hand touches the trunk.
inline std::vector<LabelCapsule> figure() {
  std::vector<LabelCapsule> shapes{{"trunk", {0, 0, 1100}, {0, 0, 600}, 100, false}};
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? "_left" : "_right";
    const double hand = side > 0 ? 150 : 135;
    shapes.push_back({"upper_arm" + end, {80 * side, 0, 1040}, {150 * side, 0, 1040}, 45});
    shapes.push_back({"upper_arm" + end, {150 * side, 0, 1040}, {150 * side, 0, 850}, 45});
    shapes.push_back({"forearm" + end, {150 * side, 0, 850}, {150 * side, 0, 700}, 45});
    shapes.push_back({"hand" + end, {hand * side, 0, 690}, {hand * side, 0, 640}, 42});
  }
  return shapes;
}

inline std::vector<SkinJoint> figure_joints() {
  std::vector<SkinJoint> joints{{"trunk", "", {}, true}};
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? "_left" : "_right";
    joints.push_back({"upper_arm" + end, "trunk", Eigen::Vector3d(0.12 * side, 0, 1.04), true});
    joints.push_back({"forearm" + end, "upper_arm" + end, Eigen::Vector3d(0.15 * side, 0, 0.83), false});
    joints.push_back({"hand" + end, "forearm" + end, Eigen::Vector3d(0.15 * side, 0, 0.67), true});
  }
  return joints;
}

/// A straight limb of radius 40 mm: three parts of 300 mm, one above the other.
inline std::vector<LabelCapsule> limb() {
  return {{"upper", {0, 0, 900}, {0, 0, 600}, 40, false},
          {"middle", {0, 0, 600}, {0, 0, 300}, 40, false},
          {"lower", {0, 0, 300}, {0, 0, 0}, 40, false}};
}

/// Whether each of the two joints twists; a joint that does not is a hinge.
inline std::vector<SkinJoint> limb_joints(bool middle_twists, bool lower_twists = false) {
  return {{"upper", "", {}, true},
          {"middle", "upper", Eigen::Vector3d(0, 0, 0.6), middle_twists},
          {"lower", "middle", Eigen::Vector3d(0, 0, 0.3), lower_twists}};
}

}  // namespace borelli::test
