#include "pipeline/motion/marker_placement.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "dynamics/numbers/rotation_vector.hpp"
#include "pipeline/body/joint_axes.hpp"
#include "pipeline/motion/scene_markers.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "pipeline/motion/static_fit.hpp"
#include "pipeline/recordings/text_rows.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Shares of a joint's range. Weak where the markers determine the pose (60 degrees of hip flexion lose 0.1
// degrees), strong where a marker's distance from its landmark comes from another person's shape.
constexpr double moving_share = 5.0 / 4, other_standing_share = 1.0 / 16, least_arm_share = 1.0 / 4;

/// In a standing trial the arms may be anywhere.
bool is_arm(const std::string& joint) {
  return joint.starts_with("shoulder") || joint.starts_with("elbow") || joint.starts_with("wrist");
}

/// The markers of a frame that a scene has.
MarkerMotion known_part(const Scene& scene, const MarkerMotion& motion) {
  MarkerMotion out{{}, motion.times, {Matrix3Xd(3, std::ssize(motion.names))}, motion.up};
  for (std::size_t m = 0; m < motion.names.size(); ++m) {
    if (std::ranges::find(scene.markers, motion.names[m], &Marker::name) == scene.markers.end()) continue;
    out.frames[0].col(std::ssize(out.names)) = motion.frames[0].col(Eigen::Index(m));
    out.names.push_back(motion.names[m]);
  }
  out.frames[0].conservativeResize(3, std::ssize(out.names));
  return out;
}

/// A pose of a standing person's arms: hanging, out to the sides, stretched forwards. The elbows are never
/// straight here, since from a straight elbow the fit does not find the direction in which it bends.
struct ArmPose {
  double flexion_deg = 0, adduction_deg = 0;  ///< of the shoulder
};
constexpr std::array<ArmPose, 3> arm_poses{{{0, 0}, {0, -80}, {80, 0}}};
constexpr double bent_elbow_deg = 30;

/// Starts all joints between segments in the anatomical position, where their coordinates are zero, except
/// those of the arms.
void start_standing(Scene& scene, const System& system, const ArmPose& arms) {
  constexpr double degree = std::numbers::pi / 180;
  VectorXd q = system.initial.q;
  for (const CoordinateInfo& c : system.coordinates) {
    const auto solid = std::size_t(solid_index(system, c.solid));
    if (!c.angle || system.bodies[std::size_t(system.solid_bodies[solid])].parent == 0) continue;
    if (c.q_size == 4) {
      const Vector3d turn = degree * Vector3d(arms.flexion_deg, arms.adduction_deg, 0);
      q.segment<4>(c.q_index) = c.name.starts_with("shoulder") ? exponential(turn) : identity_quaternion();
    } else {
      q[c.q_index] = c.name.starts_with("elbow") ? bent_elbow_deg * degree : 0;
      for (const auto& limited : system.ranges)
        if (system.coordinates[std::size_t(limited.coordinate)].name == c.name)
          q[c.q_index] = std::clamp(q[c.q_index], limited.ranges[0].lower, limited.ranges[0].upper);
    }
  }
  start_at(scene, system, q);
}

/// Markers that a frame shows, with their places.
struct ShownMarkers {
  std::vector<std::string> names;
  Matrix3Xd places;
};

ShownMarkers shown_of(const std::vector<std::string>& names, const MarkerMotion& motion, std::size_t frame) {
  ShownMarkers out;
  out.places.resize(3, Eigen::Index(names.size()));
  for (const std::string& name : names) {
    const auto column = std::ranges::find(motion.names, name) - motion.names.begin();
    if (column == std::ssize(motion.names) || !motion.frames[frame].col(column).allFinite()) continue;
    out.places.col(std::ssize(out.names)) = motion.frames[frame].col(column);
    out.names.push_back(name);
  }
  out.places.conservativeResize(3, std::ssize(out.names));
  return out;
}

std::vector<std::string> names_of(const std::vector<Marker>& markers) {
  std::vector<std::string> out;
  for (const Marker& marker : markers) out.push_back(marker.name);
  return out;
}

/// Moves the whole scene rigidly so that the markers come nearest to their places (Umeyama 1991, IEEE Trans
/// Pattern Anal Mach Intell 13:376). With fewer than three markers it stays.
Result<VectorXd> laid_onto(const Scene& scene, const System& system, const ShownMarkers& shown) {
  VectorXd q = system.initial.q;
  if (shown.names.size() < 3) return q;
  const auto before = marker_places(scene, shown.names, q);
  if (!before) return tl::unexpected(before.error());
  const Eigen::Matrix4d T = Eigen::umeyama(*before, shown.places, false);
  const Pose X{T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()};
  SolidPoses poses(system);
  poses.update(0, q);
  for (const CoordinateInfo& c : system.coordinates) {
    const int solid = solid_index(system, c.solid);
    if (system.bodies[std::size_t(system.solid_bodies[std::size_t(solid)])].parent != 0) continue;
    const Pose to = X * poses.of(solid);
    if (c.kind == "ball") q.segment<4>(c.q_index) = quaternion(to.R);
    if (c.kind != "translation") continue;
    // a free body's translations run along the world's axes, in their order
    const auto first = std::ranges::find(system.coordinates, c.solid, &CoordinateInfo::solid);
    q[c.q_index] = to.p[c.q_index - first->q_index];
  }
  return q;
}

/// Starts the scene near the trial: moved rigidly onto its markers and, for a standing person, with the arm
/// pose that fits best.
Result<void> lay_start(Scene& scene, const MarkerMotion& trial, const ShownMarkers& known, double share,
                       bool standing) {
  const Scene given = scene;
  double least = std::numeric_limits<double>::infinity();
  for (const ArmPose& arms : arm_poses) {
    Scene started = given;
    auto system = compile(started);
    if (!system) return tl::unexpected(system.error());
    if (standing) {
      start_standing(started, *system, arms);
      system = compile(started);
      if (!system) return tl::unexpected(system.error());
    }
    const auto q = laid_onto(started, *system, known);
    if (!q) return tl::unexpected(q.error());
    start_at(started, *system, *q);
    system = compile(started);
    if (!system) return tl::unexpected(system.error());
    MotionFitRequest request;
    request.rest_weights = body_rest_weights(*system, known.names.size(), share);
    const auto fit = fit_motion(started, *system, known_part(started, trial), request);
    if (!fit) return tl::unexpected(fit.error());
    if (fit->rms() < least) least = fit->rms(), scene = started;
    if (!standing) break;
  }
  return {};
}

}  // namespace

VectorXd body_rest_weights(const System& system, std::size_t markers, double share) {
  constexpr double shift = 0.01;  // m
  VectorXd weights = VectorXd::Zero(system.nv);
  for (const CoordinateInfo& c : system.coordinates) {
    const auto solid = std::size_t(solid_index(system, c.solid));
    if (!c.angle || system.bodies[std::size_t(system.solid_bodies[solid])].parent == 0) continue;
    for (int part = 0; part < c.v_size; ++part) {
      double width = 2;  // rad
      if (c.v_size == 3 && std::ranges::find(parts, c.name, &Part::joint) != parts.end()) {
        const JointAxis axis = joint_axes(c.name).axes[std::size_t(part)];
        if (!axis.motion.empty()) width = axis.range.upper - axis.range.lower;
      }
      for (const auto& limited : system.ranges)
        if (system.coordinates[std::size_t(limited.coordinate)].name == c.name)
          width = limited.ranges[std::size_t(part)].upper - limited.ranges[std::size_t(part)].lower;
      const double spread = width * (is_arm(c.name) ? std::max(share, least_arm_share) : share);
      weights[c.v_index + part] =
          shift * shift / (spread * spread) / double(std::max<std::size_t>(1, markers));
    }
  }
  return weights;
}

Result<PlacedMarkers> place_markers(const Scene& scene, const std::vector<BodyMarker>& markers,
                                    const MarkerMotion& trial, const PlacementRequest& request) {
  PlacedMarkers out;
  out.scene = scene;
  out.factors.assign(scene.solids.size(), 1);
  std::vector<Marker> following;
  {
    const auto system = compile(scene);
    if (!system) return tl::unexpected(system.error());
    SolidPoses poses(*system);
    poses.update(0, system->initial.q);
    for (const BodyMarker& marker : markers) {
      if (marker.point) {
        const Pose X_WS = poses.of(solid_index(*system, marker.segment));
        out.scene.markers.push_back({marker.name, {marker.segment, X_WS.inverse() * *marker.point}});
      } else {
        following.push_back({marker.name, {marker.segment, Vector3d::Zero()}});
      }
    }
  }
  const double share = request.standing && request.size_to_trial ? other_standing_share : moving_share;
  const ShownMarkers known = shown_of(names_of(out.scene.markers), trial, 0);
  if (known.names.size() < 3)
    return bad_use("markers",
                   fmt::format("only {} of them belong to landmarks of the body; at least 3 are needed: name "
                               "them as a common marker set does, or give --marker-map",
                               known.names.size()));
  if (auto laid = lay_start(out.scene, trial, known, share, request.standing); !laid)
    return tl::unexpected(laid.error());
  if (request.size_to_trial) {
    StaticFitRequest sizing;
    sizing.per_segment = true;
    sizing.move_markers = false;
    const auto unsized = compile(out.scene);
    if (!unsized) return tl::unexpected(unsized.error());
    sizing.rest_weights = body_rest_weights(*unsized, known.names.size(), share);
    auto sized = fit_static(out.scene, known_part(out.scene, trial), sizing);
    if (!sized) return tl::unexpected(sized.error());
    out.factors = sized->factors;
    out.warnings = sized->warnings;
    out.scene = std::move(sized->scene);
  }
  const auto system = compile(out.scene);
  if (!system) return tl::unexpected(system.error());
  MotionFitRequest fit;
  fit.rest_weights = body_rest_weights(*system, known.names.size(), share);
  const auto pose = fit_motion(out.scene, *system, known_part(out.scene, trial), fit);
  if (!pose) return tl::unexpected(pose.error());
  out.landmark_distance = pose->rms();
  const VectorXd q = pose->q.row(0).transpose();
  out.scene.markers.insert(out.scene.markers.end(), following.begin(), following.end());
  const ShownMarkers shown = shown_of(names_of(out.scene.markers), trial, 0);
  if (auto moved = move_markers(out.scene, shown.names, shown.places, q); !moved)
    return tl::unexpected(moved.error());
  // a follower that the trial does not show has no place
  std::erase_if(out.scene.markers, [&](const Marker& marker) {
    return std::ranges::find(following, marker.name, &Marker::name) != following.end() &&
           std::ranges::find(shown.names, marker.name) == shown.names.end();
  });
  start_at(out.scene, *system, q);
  return out;
}

Result<MotionFit> fit_placed(const Scene& scene, const MarkerMotion& motion,
                             const std::function<void(double)>& progress) {
  Scene started = scene;
  auto system = compile(started);
  if (!system) return tl::unexpected(system.error());
  const std::vector<std::string> names = names_of(scene.markers);
  std::size_t first = 0;
  while (first + 1 < motion.frames.size() && shown_of(names, motion, first).names.size() < 3) ++first;
  if (motion.frames.empty()) return bad_use("markers", "no frame was recorded");
  const auto q = laid_onto(started, *system, shown_of(names, motion, first));
  if (!q) return tl::unexpected(q.error());
  start_at(started, *system, *q);
  system = compile(started);
  if (!system) return tl::unexpected(system.error());
  // joints that the markers do not determine stay near their angles in the trial
  MotionFitRequest request;
  request.rest_weights = body_rest_weights(*system, names.size(), moving_share);
  request.progress = progress;
  return fit_motion(started, *system, motion, request);
}

}  // namespace borelli
