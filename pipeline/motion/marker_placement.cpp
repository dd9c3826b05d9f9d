#include "pipeline/motion/marker_placement.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pipeline/motion/scene_markers.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "pipeline/motion/static_fit.hpp"
#include "pipeline/motion/text_rows.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

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

/// Moves all that hangs on the world as one, so that the markers come nearest to their places (Umeyama 1991,
/// IEEE Trans Pattern Anal Mach Intell 13:376). Fewer than three markers: stays.
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

}  // namespace

double body_rest_weight(std::size_t markers) {
  constexpr double shift = 0.01, excursion = 0.5;  // m, rad
  return shift * shift / (excursion * excursion) / double(std::max<std::size_t>(1, markers));
}

Result<PlacedMarkers> place_markers(const Scene& scene, const std::vector<BodyMarker>& markers,
                                    const MarkerMotion& trial, bool size_to_trial) {
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
        out.followers.push_back(marker.name);
      }
    }
  }
  const ShownMarkers known = shown_of(names_of(out.scene.markers), trial, 0);
  if (known.names.size() < 3)
    return bad_use(
        "markers",
        fmt::format("only {} of them stand over landmarks of the body; at least 3 are needed (name "
                    "them as a common marker set does, or give --marker-map)",
                    known.names.size()));
  const auto start_laid = [&]() -> Result<void> {
    const auto system = compile(out.scene);
    if (!system) return tl::unexpected(system.error());
    const auto q = laid_onto(out.scene, *system, known);
    if (!q) return tl::unexpected(q.error());
    start_at(out.scene, *system, *q);
    return {};
  };
  if (auto laid = start_laid(); !laid) return tl::unexpected(laid.error());
  const double rest_weight = body_rest_weight(known.names.size());
  if (size_to_trial) {
    StaticFitRequest sizing;
    sizing.per_segment = true;
    sizing.move_markers = false;
    sizing.rest_weight = rest_weight;
    auto sized = fit_static(out.scene, trial, sizing);
    if (!sized) return tl::unexpected(sized.error());
    out.factors = sized->factors;
    out.warnings = sized->warnings;
    out.scene = std::move(sized->scene);
  }
  const auto system = compile(out.scene);
  if (!system) return tl::unexpected(system.error());
  MotionFitRequest request;
  request.rest_weight = rest_weight;
  const auto pose = fit_motion(out.scene, *system, trial, request);
  if (!pose) return tl::unexpected(pose.error());
  out.landmark_distance = pose->rms();
  const VectorXd q = pose->q.row(0).transpose();
  out.scene.markers.insert(out.scene.markers.end(), following.begin(), following.end());
  const ShownMarkers shown = shown_of(names_of(out.scene.markers), trial, 0);
  if (auto moved = move_markers(out.scene, shown.names, shown.places, q); !moved)
    return tl::unexpected(moved.error());
  // a follower that the trial does not show has no place
  std::erase_if(out.scene.markers, [&](const Marker& marker) {
    return std::ranges::find(out.followers, marker.name) != out.followers.end() &&
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
  // joints that markers do not tell stay near where the trial has them
  MotionFitRequest request;
  request.rest_weight = body_rest_weight(names.size());
  request.progress = progress;
  return fit_motion(started, *system, motion, request);
}

}  // namespace borelli
