// A known motion of the phantom, recorded by markers over its exact landmarks.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "dynamics/numbers/rotation_between.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/motion/body_markers.hpp"
#include "pipeline/motion/captured_motion.hpp"
#include "pipeline/motion/scene_markers.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "pipeline/motion/walk_plan.hpp"
#include "samples/phantom.hpp"

namespace borelli::test {

/// The phantom's exact parts.
inline PartInertials exact_parts(const Phantom& phantom) {
  PartInertials out;
  for (std::size_t label = 1; label < parts.size(); ++label)
    out[std::string(parts[label].name)] = phantom.exact[label];
  return out;
}

inline Scene still_body(const PartInertials& parts, const Landmarks& landmarks) {
  SkeletonOptions options;
  options.leap.reset();
  auto skeleton = build_skeleton(parts, landmarks, options);
  if (!skeleton) throw std::runtime_error(skeleton.error().message());
  return std::move(skeleton->scene);
}

inline std::vector<std::string> marker_names() {
  std::vector<std::string> out{"C7", "CLAV", "STRN", "T8", "Top.Head"};
  for (const char* side : {"R.", "L."})
    for (const char* name : {"ASIS", "PSIS", "Knee.Lat", "Knee.Med", "Ankle.Lat", "Ankle.Med", "Heel", "MT1",
                             "MT5", "Toe.Tip", "Elbow.Lat", "Elbow.Med", "RSP", "USP", "Hand"})
      out.push_back(std::string(side) + name);
  return out;
}

inline std::vector<std::string> segments_of(const Scene& scene) {
  std::vector<std::string> out;
  for (const Solid& solid : scene.solids) out.push_back(solid.name);
  return out;
}

/// Positions of a body that slowly bends joints and returns: the named joints turn about their first axis by
/// up to the given angle (deg), reached at 1 s.
inline RecordedPositions bending(const System& system, const std::map<std::string, double>& angles_deg) {
  RecordedPositions out;
  constexpr int count = 61;
  out.q.resize(count, system.nq);
  for (int i = 0; i < count; ++i) {
    const double t = i / 30.0, share = (1 - std::cos(std::numbers::pi * t)) / 2;
    out.times.push_back(t);
    Eigen::VectorXd q = system.initial.q;
    for (const CoordinateInfo& c : system.coordinates) {
      const auto found = angles_deg.find(c.name);
      if (found == angles_deg.end()) continue;
      const double angle = share * found->second * std::numbers::pi / 180;
      if (c.q_size == 1) {
        q[c.q_index] += angle;
        continue;
      }
      const Quaternion turn{std::cos(angle / 2), std::sin(angle / 2), 0, 0};
      q.segment<4>(c.q_index) = product(Quaternion(q.segment<4>(c.q_index)), turn);
    }
    out.q.row(i) = q.transpose();
  }
  return out;
}

/// The scene's markers at the positions, in axes whose axis `up` is the world's z.
inline MarkerMotion recording_of(const Scene& scene, const RecordedPositions& positions,
                                 const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ()) {
  MarkerMotion out;
  for (const Marker& marker : scene.markers) out.names.push_back(marker.name);
  out.times = positions.times;
  const Eigen::Matrix3d R = rotation_between(Eigen::Vector3d::UnitZ(), up);
  for (Eigen::Index i = 0; i < positions.q.rows(); ++i) {
    auto places = marker_places(scene, out.names, positions.q.row(i).transpose());
    if (!places) throw std::runtime_error(places.error().message());
    out.frames.emplace_back(R * *places);
  }
  return out;
}

/// The scene with markers over its landmarks.
inline Scene with_known_markers(Scene scene, const BodyMarkers& markers) {
  for (const BodyMarker& marker : markers.markers) {
    if (!marker.point) continue;
    // the scene starts in the scan's pose, where a solid's frame is parallel to the world's
    const auto system = compile(scene);
    if (!system) throw std::runtime_error(system.error().message());
    scene.markers.push_back({marker.name, {marker.segment, Eigen::Vector3d::Zero()}});
    if (auto moved = move_markers(scene, {marker.name}, *marker.point, system->initial.q); !moved)
      throw std::runtime_error(moved.error().message());
  }
  return scene;
}

/// A point of the sole (its index in FootSoles) that stands between two fractions of its foot's cycle.
struct StandingPoint {
  std::size_t point;
  double from, to;
};

/// Expects that points of a walking body's soles slide by less than 5 mm while they stand, and sink by less
/// than 3 mm below the floor z = 0. The left foot's cycle begins half a cycle later.
inline void expect_feet_stand(const System& system, const RecordedPositions& positions,
                              const WalkTiming& timing, const FootSoles& soles,
                              const std::vector<StandingPoint>& stands) {
  SolidPoses start(system), poses(system);
  start.update(0, system.initial.q);
  for (const auto& [name, points] : soles) {
    const int foot = solid_index(system, name);
    const double lead = name == "foot_left" ? 0.5 : 0;
    for (const StandingPoint& stand : stands) {
      const Eigen::Vector3d p_S = start.of(foot).inverse() * points[stand.point];
      std::map<double, Eigen::Vector3d> first;  // positions at the first frame, per step
      for (std::size_t i = 0; i < positions.times.size(); ++i) {
        const double cycles = positions.times[i] / timing.cycle - lead, step = std::floor(cycles);
        if (cycles - step < stand.from || cycles - step > stand.to) continue;
        poses.update(0, positions.q.row(Eigen::Index(i)).transpose());
        const Eigen::Vector3d p = poses.of(foot) * p_S;
        const Eigen::Vector3d& at = first.emplace(step, p).first->second;
        EXPECT_LT((p - at).head<2>().norm(), 0.005) << name << stand.point << " at " << cycles;
        EXPECT_GT(p.z(), -0.003) << name << stand.point << " at " << cycles;
        EXPECT_LT(p.z(), 0.005) << name << stand.point << " at " << cycles;
      }
      EXPECT_GE(first.size(), 2U) << name;
    }
  }
}

}  // namespace borelli::test
