#include "pipeline/motion/motion_transfer.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/equations/momentum.hpp"
#include "pipeline/motion/planted_feet.hpp"
#include "pipeline/motion/scaled_scene.hpp"
#include "pipeline/motion/scene_markers.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Length of the body's legs over that of the sized model's: thighs and shanks, else all solids.
double length_ratio(const Scene& scene, const std::vector<double>& factors) {
  double legs = 0, all = 0, count = 0;
  for (std::size_t s = 0; s < factors.size(); ++s) {
    all += factors[s];
    const std::string& name = scene.solids[s].name;
    if (name.starts_with("thigh") || name.starts_with("shank") || name.starts_with("leg"))
      legs += factors[s], ++count;
  }
  return count > 0 ? count / legs : double(factors.size()) / all;
}

/// The body's scene with the sized model's markers at the same places of its segments.
Scene with_markers(const BodyModel& body, const Scene& sized, const std::vector<double>& factors) {
  Scene scene = body.scene;
  for (Marker marker : sized.markers) {
    const auto solid = std::ranges::find(sized.solids, marker.at.solid, &Solid::name) - sized.solids.begin();
    marker.at.point /= factors[std::size_t(solid)];
    scene.markers.push_back(marker);
  }
  return scene;
}

/// The recorded person's mass as the forces tell it.
Result<double> mass_by_forces(const System& system, const RecordedPositions& positions,
                              const std::vector<ExternalLoad>& loads, double cutoff) {
  const auto motion = RecordedMotion::of(system, positions, cutoff);
  if (!motion) return tl::unexpected(motion.error());
  // the gravity centre's height by central differences of the smooth motion
  State state;
  VectorXd a;
  Kinematics kinematics(system, Equations::recursive);
  const auto height = [&](double t) {
    motion->at(t, state, a);
    update_kinematics(system, system.parameters, t, state.q.data(), state.v.data(), kinematics);
    return momenta(system, system.parameters, kinematics).centre.z();
  };
  constexpr double h = 0.01;                       // s
  std::vector<std::pair<double, double>> samples;  // F_z, mass
  const double g = system.parameters.gravity.norm();
  double largest = 0;
  for (double t : positions.times) {
    if (t < motion->start() + h || t > motion->end() - h) continue;
    double force = 0;
    for (const ExternalLoad& load : loads) {
      const auto& times = load.measured.times;
      const auto at = std::lower_bound(times.begin(), times.end(), t) - times.begin();
      if (at < std::ssize(times)) force += load.measured.force(2, at);
    }
    const double upwards = (height(t + h) - 2 * height(t) + height(t - h)) / (h * h);
    samples.emplace_back(force, force / (g + upwards));
    largest = std::max(largest, force);
  }
  std::vector<double> masses;
  for (const auto& [force, mass] : samples)
    if (force > 0 && force >= largest / 2) masses.push_back(mass);
  if (masses.empty()) return 0;
  std::ranges::sort(masses);
  return masses[masses.size() * 3 / 4];
}

/// A foot of the body, how many times larger the recorded person's foot is, and the floors under it.
struct FootPlace {
  std::string name;
  double factor = 1;
  const PlantedFeet& planted;

  /// Height of the floor under the foot at time t (s, within the motion), in the body's world, m.
  double floor(double t) const {
    const auto found = planted.floors.find(name);
    if (found == planted.floors.end()) return 0;
    // a load may begin or end between two times; only one of them then has the step's height
    const auto after = std::ranges::lower_bound(planted.positions.times, t) - planted.positions.times.begin();
    const std::size_t next = std::min(std::size_t(after), found->second.size() - 1);
    return std::max(found->second[next], found->second[next > 0 ? next - 1 : 0]);
  }
};

/// A load's centre of pressure moves with the foot, from the sized model's to the body's.
void move_points(MeasuredForce& measured, const System& from, const RecordedMotion& from_motion,
                 const System& to, const RecordedMotion& to_motion, const FootPlace& foot) {
  SolidPoses from_poses(from), to_poses(to);
  State state;
  VectorXd a;
  for (std::size_t i = 0; i < measured.times.size(); ++i) {
    const auto n = Eigen::Index(i);
    const double t = std::clamp(measured.times[i], from_motion.start(), from_motion.end());
    if (!measured.point.col(n).allFinite()) continue;
    from_motion.at(t, state, a);
    from_poses.update(t, state.q);
    const Vector3d local = from_poses.of(solid_index(from, foot.name)).inverse() * measured.point.col(n);
    to_motion.at(t, state, a);
    to_poses.update(t, state.q);
    measured.point.col(n) = to_poses.of(solid_index(to, foot.name)) * Vector3d(local / foot.factor);
    measured.point(2, n) = foot.floor(t);
  }
}

/// The markers as a recording of the body would show them: their places on the body plus the fit's errors.
MarkerMotion markers_on_body(const MotionFit& fit, const Scene& body, const RecordedPositions& positions,
                             const MarkerMotion& recorded) {
  MarkerMotion out{fit.markers, fit.times, {}, recorded.up};
  if (fit.markers.empty()) return out;
  std::size_t f = 0;
  for (std::size_t i = 0; i < fit.times.size(); ++i) {
    while (recorded.times[f] < fit.times[i] - 1e-9) ++f;
    const auto places = marker_places(body, fit.markers, positions.q.row(Eigen::Index(i)).transpose());
    Matrix3Xd frame = *places;
    for (std::size_t m = 0; m < fit.markers.size(); ++m) {
      const auto column = std::ranges::find(recorded.names, fit.markers[m]) - recorded.names.begin();
      frame.col(Eigen::Index(m)) += recorded.frames[f].col(column) - fit.frames[i].model.col(Eigen::Index(m));
    }
    out.frames.push_back(std::move(frame));
  }
  return out;
}

}  // namespace

Result<void> transfer_motion(CapturedMotion& motion, const BodyModel& body,
                             const std::vector<double>& factors, const CapturedMotionRequest& request) {
  const Scene sized = motion.scene;
  const auto sized_system = compile(sized);
  if (!sized_system) return tl::unexpected(sized_system.error());
  motion.length_ratio = length_ratio(sized, factors);
  Scene scene = with_markers(body, sized, factors);
  const auto trial_q = sized_system->initial.q;  // the sized model starts in the trial's pose
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());

  const FeetOnGround feet{
      .soles = body.soles, .factors = factors, .length_ratio = motion.length_ratio, .loads = motion.loads};
  auto planted = planted_positions(*sized_system, motion.positions, *system, feet);
  if (!planted) return tl::unexpected(planted.error());
  const auto from = RecordedMotion::of(*sized_system, motion.positions, request.cutoff);
  const auto to = RecordedMotion::of(*system, planted->positions, request.cutoff);
  if (!from) return tl::unexpected(from.error());
  if (!to) return tl::unexpected(to.error());

  const auto body_mass = total_mass(scene);
  if (!body_mass) return tl::unexpected(body_mass.error());
  double mass = request.recorded_mass.value_or(0);
  if (mass == 0 && !motion.loads.empty()) {
    const auto found = mass_by_forces(*sized_system, motion.positions, motion.loads, request.cutoff);
    if (!found) return tl::unexpected(found.error());
    mass = *found;
  }
  motion.mass_ratio = mass > 0 ? *body_mass / mass : 1;
  if (!motion.loads.empty())
    motion.warnings.push_back(fmt::format(
        "forces of a person of {:.1f} kg ({}) were scaled to the body's {:.1f} kg, lengths by {:.3f}", mass,
        request.recorded_mass ? "as given" : "from the forces", *body_mass, motion.length_ratio));
  for (ExternalLoad& load : motion.loads) {
    const auto solid = std::ranges::find(sized.solids, load.body, &Solid::name) - sized.solids.begin();
    move_points(load.measured, *sized_system, *from, *system, *to,
                {load.body, factors[std::size_t(solid)], *planted});
    load.measured.force *= motion.mass_ratio;
    load.measured.moment *= motion.mass_ratio * motion.length_ratio;
  }
  // the trial for the body's own size: its markers in the same pose
  std::vector<std::string> names;
  for (const Marker& marker : scene.markers) names.push_back(marker.name);
  const auto trial_places = marker_places(scene, names, trial_q);
  if (!trial_places) return tl::unexpected(trial_places.error());
  motion.trial = {names, {0}, {*trial_places}, Vector3d::UnitZ()};
  motion.markers = markers_on_body(motion.fit, scene, planted->positions, motion.markers);
  motion.positions = std::move(planted->positions);
  motion.scene = std::move(scene);
  return {};
}

}  // namespace borelli
