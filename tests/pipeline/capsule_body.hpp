// A small body of sixteen capsules for tests of drawings: volume, labels, joints, meshes and a motion in
// closed form.
#pragma once

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "dynamics/numbers/rotation_between.hpp"
#include "dynamics/scene/shape.hpp"
#include "dynamics/system/trajectory.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/export/glb.hpp"
#include "pipeline/export/mesh.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// The points within `radius` of the segment from `top` to `bottom`; patient frame, mm. `top` is the joint.
struct BodyCapsule {
  Eigen::Vector3d top, bottom;
  double radius;
};

inline std::map<std::string, BodyCapsule, std::less<>> capsule_body() {
  std::map<std::string, BodyCapsule, std::less<>> body{{"head", {{0, 0, 1520}, {0, 0, 1640}, 85}},
                                                       {"upper_trunk", {{0, 0, 1230}, {0, 0, 1380}, 125}},
                                                       {"middle_trunk", {{0, 0, 1080}, {0, 0, 1180}, 115}},
                                                       {"lower_trunk", {{0, 0, 960}, {0, 0, 1010}, 120}}};
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0 ? "_left" : "_right";
    body["upper_arm" + end] = {{190 * side, 0, 1400}, {210 * side, 0, 1140}, 45};
    body["forearm" + end] = {{212 * side, 0, 1090}, {225 * side, -20, 880}, 36};
    body["hand" + end] = {{228 * side, -25, 810}, {232 * side, -40, 700}, 30};
    body["thigh" + end] = {{85 * side, 0, 850}, {95 * side, 0, 540}, 72};
    body["shank" + end] = {{97 * side, 0, 440}, {100 * side, 15, 120}, 50};
    body["foot" + end] = {{100 * side, 10, 45}, {104 * side, -120, 35}, 36};
  }
  return body;
}

inline double distance_to_axis(const BodyCapsule& capsule, const Eigen::Vector3d& point) {
  const Eigen::Vector3d along = capsule.bottom - capsule.top;
  const double s = std::clamp((point - capsule.top).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - capsule.top - s * along).norm();
}

/// The body voxelised: CT numbers 40 inside with a bone of 700 along each axis, -1000 outside.
struct CapsuleScan {
  GreyVolume grey;
  LabelMap labels;
};

inline CapsuleScan capsule_scan(const Grid& grid) {
  CapsuleScan scan;
  scan.grey.grid = scan.labels.grid = grid;
  scan.grey.voxels.assign(grid.count(), -1000);
  scan.labels.voxels.assign(grid.count(), 0);
  for (const Part& part : parts) scan.labels.names.emplace_back(part.name);
  const auto body = capsule_body();
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i)
        for (const auto& [name, capsule] : body) {
          const Eigen::Vector3d point = grid.point(i, j, k);
          const double depth = distance_to_axis(capsule, point);
          if (depth > capsule.radius) continue;
          scan.labels.at(i, j, k) = static_cast<std::uint8_t>(part_label(name));
          scan.grey.at(i, j, k) = static_cast<std::int16_t>(depth < 0.3 * capsule.radius ? 700 : 40);
        }
  return scan;
}

inline Grid capsule_grid(double spacing) {
  Grid grid;
  grid.axes *= spacing;
  grid.origin = {-300, -180, -20};
  for (int c = 0; c < 3; ++c)
    grid.size[static_cast<std::size_t>(c)] =
        static_cast<std::int64_t>(std::ceil(Eigen::Vector3d(600, 340, 1780)[c] / spacing));
  return grid;
}

/// The capsule's surface as rings of points, closed at both ends; world axes, m.
inline Mesh capsule_mesh(const std::string& name, const BodyCapsule& capsule, int around = 24,
                         int cap_rings = 6) {
  Mesh mesh{name, {}, {}};
  const Eigen::Vector3d axis = (capsule.bottom - capsule.top).normalized();
  const Eigen::Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
  const auto add = [&](const Eigen::Vector3d& mm) {
    mesh.points.push_back({static_cast<float>(mm[0] * 1e-3), static_cast<float>(mm[1] * 1e-3),
                           static_cast<float>(mm[2] * 1e-3)});
    return static_cast<std::uint32_t>(mesh.points.size() - 1);
  };
  std::vector<std::vector<std::uint32_t>> rings;
  for (int end = 0; end < 2; ++end)
    for (int ring = 0; ring < cap_rings; ++ring) {
      const int step = end == 0 ? ring + 1 : cap_rings - ring;
      const double angle = std::numbers::pi / 2 * (1 - static_cast<double>(step) / cap_rings);
      const double lift = capsule.radius * std::sin(angle) * (end == 0 ? -1 : 1);
      const Eigen::Vector3d centre = (end == 0 ? capsule.top : capsule.bottom) + lift * axis;
      rings.emplace_back();
      for (int i = 0; i < around; ++i) {
        const double turn = 2 * std::numbers::pi * i / around;
        rings.back().push_back(
            add(centre + capsule.radius * std::cos(angle) * (std::cos(turn) * u + std::sin(turn) * v)));
      }
    }
  const auto first = add(capsule.top - capsule.radius * axis);
  const auto last = add(capsule.bottom + capsule.radius * axis);
  const auto n = static_cast<std::size_t>(around);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    mesh.triangles.push_back({first, rings.front()[next], rings.front()[i]});
    mesh.triangles.push_back({last, rings.back()[i], rings.back()[next]});
    for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
      mesh.triangles.push_back({rings[r][i], rings[r][next], rings[r + 1][next]});
      mesh.triangles.push_back({rings[r][i], rings[r + 1][next], rings[r + 1][i]});
    }
  }
  return mesh;
}

inline std::vector<Mesh> capsule_meshes() {
  std::vector<Mesh> meshes;
  for (const auto& [name, capsule] : capsule_body()) meshes.push_back(capsule_mesh(name, capsule));
  return meshes;
}

/// The body's inertia table at 1040 kg/m^3, in the form of inertia/table.json. The left foot counts as cut.
inline nlohmann::json capsule_table() {
  std::vector<InertiaRow> rows;
  const auto body = capsule_body();
  for (const Part& part : parts) {
    const auto found = body.find(part.name);
    if (found == body.end()) continue;
    const auto& [top, bottom, radius] = found->second;
    const Eigen::Vector3d axis = (top - bottom) * 1e-3;
    const Shape shape{Capsule{radius * 1e-3, axis.norm()}, (top + bottom) * 0.5e-3,
                      Eigen::Quaterniond(rotation_between(Eigen::Vector3d::UnitZ(), axis))};
    InertiaRow row;
    row.part = part.name;
    row.completeness = part.name == "foot_left" ? Completeness::cut : Completeness::whole;
    row.inertial = inertial_of_density(shape, 1040).value();
    row.volume = row.inertial.mass / 1040;
    if (part.name.starts_with("shank")) {
      row.frame = SegmentFrame{"shank",
                               "KJC",
                               "AJC",
                               top * 1e-3,
                               bottom * 1e-3,
                               -axis.normalized(),
                               shape.orientation.toRotationMatrix() *
                                   rotation_about(Eigen::Vector3d::UnitX(), std::numbers::pi / 2),
                               "along the capsule",
                               "joint"};
      row.notes = {"A capsule <i>and no shank</i>."};
    }
    rows.push_back(std::move(row));
  }
  InertiaSource source;
  source.quantity = "hu";
  source.density_curve = "water";
  source.sex = "male";
  return nlohmann::json::parse(to_json(make_table(source, rows)));
}

/// Solid frames: patient axes at each part's top (its joint).
inline ScanPoses capsule_scan_poses() {
  ScanPoses poses;
  for (const auto& [name, capsule] : capsule_body())
    poses[name] = Pose{Eigen::Matrix3d::Identity(), capsule.top * 1e-3};
  return poses;
}

inline Landmarks capsule_joints() {
  Landmarks joints;
  const auto body = capsule_body();
  for (const Part& part : parts)
    if (!part.joint.empty())
      joints[std::string(part.joint)] = Landmark{body.find(part.name)->second.top, 1.5, 0, "exact"};
  return joints;
}

/// Two seconds in which the limbs swing about the left-right axis through their joints and the body turns
/// once about the vertical, more than a half turn between some quaternion signs.
inline Trajectory capsule_motion(double rate = 100, double duration = 2) {
  Trajectory motion;
  const auto body = capsule_body();
  for (const Part& part : parts)
    if (part_label(part.name) > 0) motion.solids.emplace_back(part.name);
  const auto steps = static_cast<int>(std::lround(rate * duration));
  const auto local = [&](const std::string& name, double t) -> Pose {
    const bool limb = name.find("_left") != std::string::npos || name.find("_right") != std::string::npos;
    const double sign =
        (name.find("left") != std::string::npos) == (name.find("arm") != std::string::npos) ? 1 : -1;
    const double swing = limb && name.find("trunk") == std::string::npos
                             ? sign * 0.35 * std::sin(2 * std::numbers::pi * t)
                             : 0;
    return {rotation_about(Eigen::Vector3d::UnitX(), swing), Eigen::Vector3d::Zero()};
  };
  for (int step = 0; step <= steps; ++step) {
    const double t = step / rate;
    const Pose turn{rotation_about(Eigen::Vector3d::UnitZ(), std::numbers::pi * t), {0.1 * t, 0, 0}};
    std::map<std::string, Pose, std::less<>> X_W;
    const auto pose_of = [&](auto&& self, std::string_view name) -> Pose {
      const Part& part = parts[static_cast<std::size_t>(part_label(name))];
      const Eigen::Vector3d top = body.find(name)->second.top * 1e-3;
      if (part.parent.empty()) return turn * Pose{Eigen::Matrix3d::Identity(), top};
      const Eigen::Vector3d from_parent = top - body.find(part.parent)->second.top * 1e-3;
      return self(self, part.parent) * Pose{Eigen::Matrix3d::Identity(), from_parent} *
             local(std::string(name), t);
    };
    motion.times.push_back(t);
    for (const std::string& name : motion.solids) motion.poses.push_back(pose_of(pose_of, name));
    motion.kinetic.push_back(40 + 12 * std::cos(4 * std::numbers::pi * t));
    motion.potential.push_back(650 - 12 * std::cos(4 * std::numbers::pi * t) + 1e-7 * t);
    motion.work.push_back(0);
  }
  motion.gravity_centre = Rows::Zero(steps + 1, 3);
  for (int step = 0; step <= steps; ++step) motion.gravity_centre.row(step) << 0.1 * step / rate, 0, 0.95;
  motion.q = motion.v = motion.a = Rows::Zero(steps + 1, 39);
  auto& certificate = motion.certificate;
  certificate.trusted = true;
  certificate.energy_drift = 2e-7;
  certificate.energy_drift_time = duration;
  certificate.energy_turnover = 96;
  certificate.energy_threshold = 1e-6;
  certificate.conserved = {{"linear momentum, x", 1e-11, 7.3, 1.2}};
  certificate.steps_accepted = 412;
  certificate.steps_rejected = 9;
  certificate.evaluations = 5052;
  certificate.smallest_step = 1.3e-3;
  certificate.smallest_step_time = 0.25;
  return motion;
}

}  // namespace borelli
