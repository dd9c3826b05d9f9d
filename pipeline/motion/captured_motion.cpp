#include "pipeline/motion/captured_motion.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/numbers/rotation_between.hpp"
#include "dynamics/numbers/rotation_vector.hpp"
#include "error/printable.hpp"
#include "pipeline/body/joint_axes.hpp"
#include "pipeline/motion/angle_motion.hpp"
#include "pipeline/motion/foot_contact.hpp"
#include "pipeline/motion/marker_calibration.hpp"
#include "pipeline/motion/marker_placement.hpp"
#include "pipeline/motion/motion_transfer.hpp"
#include "pipeline/motion/scaled_scene.hpp"
#include "pipeline/motion/scene_markers.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "pipeline/motion/static_fit.hpp"
#include "pipeline/recordings/text_rows.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double far_from_landmarks = 0.03;  // m
constexpr double large_error = 0.015;        // m

bool is_foot(const std::string& segment) { return segment.starts_with("foot") || segment.starts_with("leg"); }
bool is_trunk(const std::string& segment) { return segment.ends_with("trunk") || segment == "head"; }

/// The file's axis along which trunk and head lie above the feet.
Result<Vector3d> up_of(const MarkerMotion& motion, const BodyMarkers& markers) {
  if (motion.up) return *motion.up;
  Vector3d sums[2] = {Vector3d::Zero(), Vector3d::Zero()};
  double counts[2] = {0, 0};
  for (const BodyMarker& marker : markers.markers) {
    const int kind = is_trunk(marker.segment) ? 1 : is_foot(marker.segment) ? 0 : -1;
    const auto column = std::ranges::find(motion.names, marker.name) - motion.names.begin();
    if (kind < 0 || column == std::ssize(motion.names)) continue;
    for (const Matrix3Xd& frame : motion.frames)
      if (frame.col(column).allFinite()) sums[kind] += frame.col(column), ++counts[kind];
  }
  if (counts[0] == 0 || counts[1] == 0)
    return bad_use("markers",
                   "do not show which way is up: no marker on the feet, or none on the trunk, has a known "
                   "name; give --marker-map");
  const Vector3d rise = sums[1] / counts[1] - sums[0] / counts[0];
  Eigen::Index axis = 0;
  rise.cwiseAbs().maxCoeff(&axis);
  return Vector3d(Vector3d::Unit(axis) * (rise[axis] > 0 ? 1 : -1));
}

MarkerMotion turned(MarkerMotion motion, const Matrix3d& R) {
  for (Matrix3Xd& frame : motion.frames) frame = R * frame;
  motion.up = Vector3d::UnitZ();
  return motion;
}

/// The first frame that shows most of the known markers.
MarkerMotion fullest_frame(const MarkerMotion& motion, const BodyMarkers& markers) {
  std::size_t best = 0;
  int most = -1;
  for (std::size_t f = 0; f < motion.frames.size(); ++f) {
    int seen = 0;
    for (const BodyMarker& marker : markers.markers) {
      const auto column = std::ranges::find(motion.names, marker.name) - motion.names.begin();
      seen += column < std::ssize(motion.names) && motion.frames[f].col(column).allFinite();
    }
    if (seen > most) most = seen, best = f;
  }
  return {motion.names, {0}, {motion.frames[best]}, motion.up};
}

void warn_of_placement(const CapturedMotion& out, bool other_person, std::vector<std::string>& warnings) {
  if (out.landmark_distance > far_from_landmarks)
    warnings.push_back(fmt::format(
        "the markers lie {:.0f} mm (rms) from the body's landmarks: {}", 1e3 * out.landmark_distance,
        other_person ? "the body's landmarks or the markers' names may be wrong"
                     : "if the recorded person is not the scanned one, add --other-person"));
}

/// Moves the markers on the body to the places that the motion determines.
Result<void> calibrate(CapturedMotion& out) {
  auto moved = calibrated_markers(out.scene, out.markers);
  if (!moved) return tl::unexpected(moved.error());
  out.scene = std::move(moved->scene);
  out.calibrated = true;
  return {};
}

void warn_of_errors(CapturedMotion& out) {
  if (!out.calibrated && out.fit.rms() > large_error)
    out.warnings.push_back(
        fmt::format("the marker errors are {:.0f} mm (rms); the markers may have moved since the standing "
                    "trial: add --calibrate-markers",
                    1e3 * out.fit.rms()));
}

/// The body's ground forces, by the foot that stands on each plate.
Result<void> add_loads(CapturedMotion& out, const System& system, const std::vector<MeasuredForce>& forces,
                       double cutoff) {
  if (forces.empty()) {
    out.warnings.emplace_back(
        "no ground force is given, so the force that carries the body appears as a residual at the root");
    return {};
  }
  const auto motion = RecordedMotion::of(system, out.positions, cutoff);
  if (!motion) return tl::unexpected(motion.error());
  auto loads = loads_on_feet(system, *motion, forces, feet_of(system));
  if (!loads) return tl::unexpected(loads.error());
  out.warnings.insert(out.warnings.end(), loads->warnings.begin(), loads->warnings.end());
  out.loads = std::move(loads->loads);
  return {};
}

/// Warns of ball joints that leave their published ranges by more than 10 degrees, the spread of such ranges
/// among people.
void warn_of_ranges(CapturedMotion& out, const System& system) {
  constexpr double spread = 10 * std::numbers::pi / 180;
  std::vector<std::string> beyond;
  for (const CoordinateInfo& c : system.coordinates) {
    const auto solid = std::size_t(solid_index(system, c.solid));
    if (c.q_size != 4 || system.bodies[std::size_t(system.solid_bodies[solid])].parent == 0) continue;
    const JointAxes joint = joint_axes(c.name);
    for (int axis = 0; axis < 3; ++axis) {
      const JointAxis& usual = joint.axes[std::size_t(axis)];
      double excess = 0, worst = 0;
      for (Eigen::Index i = 0; i < out.positions.q.rows(); ++i) {
        const Quaternion turn = out.positions.q.row(i).segment<4>(c.q_index).transpose();
        const double angle = logarithm(turn)[axis];
        const double past = std::max(usual.range.lower - angle, angle - usual.range.upper);
        if (past > excess) excess = past, worst = angle;
      }
      if (excess > spread)
        beyond.push_back(
            fmt::format("{} {} {:.0f} deg", c.name, usual.motion, worst * 180 / std::numbers::pi));
    }
  }
  if (!beyond.empty())
    out.warnings.push_back(fmt::format(
        "joints go more than 10 degrees beyond their usual ranges: {}; markers or landmarks may be "
        "misplaced there",
        name_list(beyond)));
}

/// Adds loads to the positions; transfers both to the body if another person was recorded; then adds joint
/// moments.
Result<CapturedMotion> with_efforts(CapturedMotion out, const BodyModel& body,
                                    const std::vector<double>& factors,
                                    const std::vector<MeasuredForce>& forces,
                                    const CapturedMotionRequest& request) {
  {
    const auto system = compile(out.scene);
    if (!system) return tl::unexpected(system.error());
    if (auto added = add_loads(out, *system, forces, request.cutoff); !added)
      return tl::unexpected(added.error());
  }
  if (request.other_person)
    if (auto moved = transfer_motion(out, body, factors, request); !moved)
      return tl::unexpected(moved.error());

  const auto system = compile(out.scene);
  if (!system) return tl::unexpected(system.error());
  warn_of_ranges(out, *system);
  start_at(out.scene, *system, out.positions.q.row(0).transpose());
  MotionEffortsRequest asked;
  asked.cutoff = request.cutoff;
  auto efforts = efforts_of(*system, out.positions, out.loads, asked);
  if (!efforts) return tl::unexpected(efforts.error());
  out.efforts = std::move(*efforts);
  out.warnings.insert(out.warnings.end(), out.efforts.warnings.begin(), out.efforts.warnings.end());
  return out;
}

/// The axis along which the ground pushes on average.
Vector3d up_of_forces(const std::vector<MeasuredForce>& forces) {
  Vector3d sum = Vector3d::Zero();
  for (const MeasuredForce& force : forces)
    for (Eigen::Index i = 0; i < force.force.cols(); ++i)
      if (force.force.col(i).allFinite()) sum += force.force.col(i);
  Eigen::Index axis = 2;
  if (!sum.isZero()) sum.cwiseAbs().maxCoeff(&axis);
  return Vector3d::Unit(axis) * (sum[axis] < 0 ? -1 : 1);
}

/// Forces in the world, whose z is up.
std::vector<MeasuredForce> turned_forces(std::vector<MeasuredForce> forces, const Vector3d& up) {
  const Matrix3d R = rotation_between(up, Vector3d::UnitZ());
  for (MeasuredForce& force : forces)
    for (Matrix3Xd* values : {&force.force, &force.point, &force.moment}) *values = R * *values;
  return forces;
}

}  // namespace

Result<CapturedMotion> captured_motion(const BodyModel& body, const BodyMarkers& markers,
                                       const CapturedRecording& recording,
                                       const CapturedMotionRequest& request) {
  CapturedMotion out;
  if (!markers.unknown.empty())
    out.warnings.push_back(
        fmt::format("left out markers whose names are not known: {}; --marker-map can place them",
                    printable_list(markers.unknown)));
  const auto up = up_of(recording.motion, markers);
  if (!up) return tl::unexpected(up.error());
  const Matrix3d R = rotation_between(*up, Vector3d::UnitZ());
  out.markers = turned(recording.motion, R);
  const MarkerMotion trial = recording.trial ? mean_frame(turned(*recording.trial, R), -1e300, 1e300)
                                             : fullest_frame(out.markers, markers);
  const std::vector<MeasuredForce> forces = turned_forces(recording.forces, *up);

  auto placed =
      place_markers(body.scene, markers.markers, trial, {request.other_person, recording.trial.has_value()});
  if (!placed) return tl::unexpected(placed.error());
  out.trial = trial;
  out.standing = recording.trial.has_value();
  out.landmark_distance = placed->landmark_distance;
  out.warnings.insert(out.warnings.end(), placed->warnings.begin(), placed->warnings.end());
  warn_of_placement(out, request.other_person, out.warnings);

  out.scene = std::move(placed->scene);
  if (request.calibrate)
    if (auto moved = calibrate(out); !moved) return tl::unexpected(moved.error());
  auto fit = fit_placed(out.scene, out.markers, request.progress);
  if (!fit) return tl::unexpected(fit.error());
  out.fit = std::move(*fit);
  out.warnings.insert(out.warnings.end(), out.fit.warnings.begin(), out.fit.warnings.end());
  warn_of_errors(out);
  out.positions = {out.fit.times, out.fit.q};
  return with_efforts(std::move(out), body, placed->factors, forces, request);
}

Result<CapturedMotion> captured_angles(const BodyModel& body, const Landmarks& landmarks,
                                       const CapturedAngles& recording,
                                       const CapturedMotionRequest& request) {
  const auto system = compile(body.scene);
  if (!system) return tl::unexpected(system.error());
  auto angles = angle_motion(*system, landmarks, recording.angles);
  if (!angles) return tl::unexpected(angles.error());
  CapturedMotion out;
  out.warnings = angles->warnings;
  const double size = request.other_person ? size_by_height(*system, *angles, body.soles) : 1;
  if (!(size > 0.4 && size < 2.5))
    return bad_use("motion", fmt::format("places the pelvis at {:.2f} leg lengths above the floor; its floor "
                                         "must be at height 0, its unit m",
                                         size));
  out.positions = at_size(*system, *angles, size);
  out.fit.times = out.positions.times;
  out.fit.q = out.positions.q;
  const std::vector<double> factors(body.scene.solids.size(), size);
  out.scene = size == 1 ? body.scene : scaled(body.scene, factors).scene;
  out.trial.up = out.markers.up = Vector3d::UnitZ();
  const auto forces = turned_forces(recording.forces, recording.up.value_or(up_of_forces(recording.forces)));
  return with_efforts(std::move(out), body, factors, forces, request);
}

}  // namespace borelli
