#include "segmentation/labelling/bones_at_joints.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/grid/geodesic.hpp"
#include "segmentation/vocabulary/cuts.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Joint {
  std::string kind;  // "hip", "knee" ...
  int proximal = 0, distal = 0;
  Vector3d centre, up, axis, front;  // up: away from the distal bone; axis: lateral; unit
  double radius = 0, reach = 0;      // of the joint surface; of the relabelled region; mm
  double foremost = -1e9;            // of the foremost bone at a knee, along `front` from the centre
};

struct Shape {
  const char* kind;
  double radius, reach;  // an adult's, mm; the radius is used if the landmark has none
};
constexpr std::array<Shape, 6> shapes{{{"hip", 24, 60},
                                       {"shoulder", 23, 48},
                                       {"knee", 22, 75},
                                       {"elbow", 11, 45},
                                       {"ankle", 20, 95},
                                       {"wrist", 0, 40}}};

std::optional<Joint> joint_of(const Part& part, int label, const Landmarks& landmarks, double scale) {
  const std::string name(part.joint);
  const auto cut = name.find('_');
  if (cut == std::string::npos) return std::nullopt;
  const std::string kind = name.substr(0, cut), side = name.substr(cut);
  const auto at = [&](const std::string& point) -> std::optional<Vector3d> {
    const auto it = landmarks.find(point);
    return it == landmarks.end() ? std::nullopt : std::optional(it->second.point);
  };
  const auto centre = at(name);
  for (const Shape& shape : shapes) {
    if (kind != shape.kind || !centre) continue;
    const Eigen::Matrix3d axes = trunk_axes(landmarks);
    Joint joint{kind, part_label(part.parent), label, *centre, axes.col(2), {}, {}, 0, shape.reach * scale};
    const std::string far = kind == "hip"        ? "knee"
                            : kind == "knee"     ? "ankle"
                            : kind == "shoulder" ? "elbow"
                            : kind == "elbow"    ? "wrist"
                            : kind == "wrist"    ? "metacarpale_3"
                                                 : "";
    // at an ankle the proximal bone gives the direction
    const auto end = at(far + side), above = at("knee" + side);
    if (!far.empty() && end) joint.up = (*centre - *end).normalized();
    if (far.empty() && above) joint.up = (*above - *centre).normalized();
    const Vector3d lateral = side == "_left" ? axes.col(0) : Vector3d(-axes.col(0));
    const auto medial_end = at(kind + "_medial" + side), lateral_end = at(kind + "_lateral" + side);
    joint.axis = medial_end && lateral_end ? (*lateral_end - *medial_end).normalized() : lateral;
    joint.axis = (joint.axis - joint.axis.dot(joint.up) * joint.up).normalized();
    joint.front = joint.axis.cross(joint.up);
    if (joint.front.dot(-axes.col(1)) < 0) joint.front = -joint.front;
    const double found = landmarks.find(name)->second.radius;
    joint.radius = found > 0 ? found : shape.radius * scale;
    return joint;
  }
  return std::nullopt;
}

bool of_joint(const Joint& joint, int label) {
  return label == joint.distal || label == joint.proximal || (is_axial(joint.proximal) && is_axial(label));
}

// The certain label of a point near a joint; 0 if uncertain. `label`: its present label.
int seed_at(const Joint& joint, const Vector3d& p, int label) {
  const Vector3d d = p - joint.centre;
  const int proximal = is_axial(joint.proximal) && is_axial(label) ? label : joint.proximal;
  const double r = joint.radius, along = d.dot(joint.axis), up = d.dot(joint.up);
  if (joint.kind == "hip" || joint.kind == "shoulder") {
    // thick slices blur the joint space, so that the fitted ball is up to 4 mm too wide
    if (d.norm() <= 0.85 * r) return joint.distal;
    const Vector3d inwards = (-joint.axis + 0.5 * joint.up).normalized();
    if (d.norm() >= r + 1.5 && d.dot(inwards) > 0.3 * d.norm()) return proximal;
    return joint.kind == "shoulder" && up > r + 5 ? proximal : 0;
  }
  const Vector3d across = d - along * joint.axis;
  const double front = d.dot(joint.front);
  if (joint.kind == "knee") {
    if (joint.foremost > r + 10 && front > joint.foremost - 6 && up > -10) return joint.distal;
    if (across.norm() <= r) return proximal;
    if (up < -(r + 2)) return joint.distal;
    return up > -r && front < r + 4 ? proximal : 0;
  }
  if (joint.kind == "elbow") {
    if (across.norm() <= r) return proximal;
    if (up < -(r + 2)) return joint.distal;
    return up > 2.5 * r && front > -r ? proximal : 0;
  }
  // ankle and wrist divide at the level of the joint centre; the heel behind the ankle may reach as high
  if (up > 0 && joint.kind == "ankle" && (d - up * joint.up).norm() > 25) return 0;
  return up < 0 ? joint.distal : proximal;
}

}  // namespace

void part_bones_at_joints(const Anatomy& a, const Landmarks& landmarks, double scale,
                          Volume<std::uint8_t>& bones) {
  const auto& g = a.grid();
  std::vector<Joint> joints;
  for (std::size_t label = 1; label < parts.size(); ++label)
    if (const auto joint = joint_of(parts[label], static_cast<int>(label), landmarks, scale))
      joints.push_back(*joint);
  const auto each = [&](const auto& visit) {
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i)
          if (bones.at(i, j, k)) visit(g.offset(i, j, k), g.point(i, j, k));
  };
  for (Joint& joint : joints)
    if (joint.kind == "knee")
      each([&](std::size_t o, const Vector3d& p) {
        const Vector3d d = p - joint.centre;
        if (of_joint(joint, bones.voxels[o]) && d.norm() < joint.reach && d.dot(joint.up) > -10 &&
            std::abs(d.dot(joint.axis)) < 35 * scale)
          joint.foremost = std::max(joint.foremost, d.dot(joint.front));
      });

  Volume<float> cost{g, std::vector<float>(g.count(), no_path)};
  Volume<std::uint8_t> seeds{g, std::vector<std::uint8_t>(g.count(), 0)};
  for (std::size_t o = 0; o < g.count(); ++o) {
    if (!a.body.voxels[o] || a.off_bone[o] > 9) continue;
    const float off = a.off_bone[o];
    cost.voxels[o] = off > 0 ? 4 + off * off : 1 / (0.4F + a.within_bone[o] / 10);
  }
  each([&](std::size_t o, const Vector3d& p) {
    int label = bones.voxels[o];
    for (const Joint& joint : joints)
      if (of_joint(joint, bones.voxels[o]) && (p - joint.centre).norm() < joint.reach) {
        label = seed_at(joint, p, bones.voxels[o]);
        break;
      }
    seeds.voxels[o] = static_cast<std::uint8_t>(label);
  });
  const auto owner = nearest_seeds({cost, a.threads}, seeds);
  for (std::size_t o = 0; o < g.count(); ++o)
    if (bones.voxels[o] && owner.voxels[o]) bones.voxels[o] = owner.voxels[o];
}

}  // namespace borelli
