#include "pipeline/motion/sample_walk.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "dynamics/inverse/marker_fit.hpp"
#include "pipeline/motion/gait_angles.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "pipeline/motion/walk_forces.hpp"

namespace borelli {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr int cycle_samples = 100;
constexpr int walk_harmonics = 9;
constexpr int pendulum_rounds = 8;
constexpr double pendulum_step = 0.6;  // of the correction, so that the rounds converge
// m: the hips are this much lower than the angles give, since a leg that must stretch fully jerks
constexpr double knee_room = 0.04;
constexpr double pose_arm = 0.1;  // m, of the points that hold a solid's pose
constexpr double foot_weight = 3000, pelvis_weight = 300;
constexpr double leg_weight = 1;
constexpr double degree = std::numbers::pi / 180;

/// Turns the coordinates of a solid's joint.
class JointTurns {
 public:
  explicit JointTurns(const System& system) : system_(system) {}

  /// Ball: from its initial value on, about an axis of its parent's. Hinge: the angle.
  void turn(VectorXd& q, const std::string& solid, double angle,
            const Vector3d& axis = Vector3d::UnitX()) const {
    for (const CoordinateInfo& c : system_.coordinates) {
      if (c.solid != solid || !c.angle) continue;
      if (c.q_size == 1) {
        q[c.q_index] = angle;
        continue;
      }
      const Eigen::Quaterniond old(q[c.q_index], q[c.q_index + 1], q[c.q_index + 2], q[c.q_index + 3]);
      const Eigen::Quaterniond now = Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)) * old;
      q.segment<4>(c.q_index) << now.w(), now.x(), now.y(), now.z();
    }
  }

 private:
  const System& system_;
};

/// First index of the root's translations; -1: it does not have three.
int root_index(const System& system) {
  int count = 0, first = -1;
  for (const CoordinateInfo& c : system.coordinates)
    if (c.solid == "lower_trunk" && c.kind == "translation") {
      if (count++ == 0) first = c.q_index;
    }
  return count == 3 ? first : -1;
}

/// Sketched angles of all joints, with the root at its start; at a time in cycles.
VectorXd sketched_posture(const System& system, double cycles) {
  VectorXd q = system.initial.q;
  const JointTurns joints(system);
  for (const bool left : {false, true}) {
    const std::string side = left ? "_left" : "_right";
    const double phase = cycles - (left ? 0.5 : 0), swing = std::cos(2 * std::numbers::pi * phase);
    const LegAngles leg = leg_angles(phase);
    joints.turn(q, "thigh" + side, leg.hip);
    joints.turn(q, "shank" + side, leg.knee);
    joints.turn(q, "foot" + side, leg.ankle);
    // arms swing against the legs (Perry and Burnfield 2010, chapter 7)
    joints.turn(q, "upper_arm" + side, -(4 + 16 * swing) * degree);
    joints.turn(q, "forearm" + side, (22 - 10 * swing) * degree);
  }
  const double turn = std::cos(2 * std::numbers::pi * cycles) * degree;
  joints.turn(q, "lower_trunk", 4 * turn, Vector3d::UnitZ());
  joints.turn(q, "middle_trunk", -3 * turn, Vector3d::UnitZ());
  joints.turn(q, "upper_trunk", -4 * turn, Vector3d::UnitZ());
  joints.turn(q, "head", 3 * turn, Vector3d::UnitZ());
  return q;
}

/// Makes one cycle of the walk. Rows of its positions are those of a body that walks on the spot: the way
/// speed * time is taken off.
class WalkMaker {
 public:
  static Result<WalkMaker> create(const System& system, const FootSoles& soles,
                                  const SampleWalkOptions& options) {
    SolidPoses poses(system);
    poses.update(0, system.initial.q);
    std::map<std::string, Pose, std::less<>> start;
    for (std::size_t s = 0; s < system.solids.size(); ++s) start[system.solids[s]] = poses.of(int(s));
    auto feet = walking_feet(start, soles, options.step_width);
    if (!feet) return tl::unexpected(feet.error());
    for (const char* solid : {"lower_trunk", "thigh_left", "thigh_right", "shank_left", "shank_right"})
      if (!start.contains(solid)) return bad_use("sample walk", fmt::format("the body has no {}", solid));
    if (root_index(system) < 0) return bad_use("sample walk", "the lower trunk is no free body");
    std::vector<FollowedMarker> followed;
    for (const auto& [solid, weight] : followed_solids)
      for (int k = 0; k < 3; ++k) followed.push_back({solid, {solid, pose_arm * Vector3d::Unit(k)}, weight});
    auto fit = MarkerFit::create(system, std::move(followed), {}, {.within_ranges = false});
    if (!fit) return tl::unexpected(fit.error());
    return WalkMaker(system, *feet, {options.speed, 120 / options.cadence}, std::move(*fit));
  }

  /// The smooth cycle, #cycle_samples by nq.
  Result<MatrixXd> cycle() {
    MatrixXd root = root_path(), q(cycle_samples, system_->nq), best;
    double least = std::numeric_limits<double>::infinity();
    for (int round = 0; round < pendulum_rounds; ++round) {
      for (int i = 0; i < cycle_samples; ++i)
        if (auto done = fit_legs(i, root.row(i).transpose(), q); !done) return tl::unexpected(done.error());
      q = smoothed(q);
      const MatrixXd error = pressure_error(q);
      if (const double worst = error.cwiseAbs().maxCoeff(); worst < least) least = worst, best = q;
      root.leftCols<2>() -= pendulum_step * sway(error);
    }
    return best;
  }

  VectorXd positions(const PeriodicSeries& series, double t) const {
    VectorXd q = series.at(t / timing_.cycle);
    for (const CoordinateInfo& c : system_->coordinates)
      if (c.q_size == 4) q.segment<4>(c.q_index).normalize();
    q[root_ + 1] -= timing_.speed * t;
    return q;
  }

  const WalkTiming& timing() const { return timing_; }
  const std::array<WalkingFoot, 2>& feet() const { return feet_; }

 private:
  struct Weight {
    const char* solid;
    double weight;
  };
  static constexpr std::array<Weight, 7> followed_solids{{{"foot_right", foot_weight},
                                                          {"foot_left", foot_weight},
                                                          {"lower_trunk", pelvis_weight},
                                                          {"thigh_right", leg_weight},
                                                          {"thigh_left", leg_weight},
                                                          {"shank_right", leg_weight},
                                                          {"shank_left", leg_weight}}};

  WalkMaker(const System& system, const std::array<WalkingFoot, 2>& feet, WalkTiming timing, MarkerFit fit)
      : system_(&system), feet_(feet), timing_(timing), fit_(std::move(fit)), root_(root_index(system)) {}

  /// Planned centre of pressure of the two feet together, less the forward motion speed * t.
  Eigen::Vector2d pressure(double cycles) const {
    Eigen::Vector2d sum(0, timing_.stride() * cycles);
    for (const WalkingFoot& foot : feet_)
      if (const double share = planned_share(foot, cycles); share > 0)
        sum += share * planned_pressure(foot, timing_, cycles).head<2>();
    return sum;
  }

  /// Path x of the centre of a linear inverted pendulum above a centre of pressure p: x - (z / g) x'' = p.
  MatrixXd sway(const MatrixXd& pressures) const {
    PeriodicSeries series(pressures, walk_harmonics);
    const double height = system_->initial.q[root_ + 2];
    for (Eigen::Index k = 0; k <= walk_harmonics; ++k) {
      const double w = 2 * std::numbers::pi * double(k) / timing_.cycle;
      const double gain = 1 / (1 + w * w * height / 9.81);
      series.cosines.row(k) *= gain, series.sines.row(k) *= gain;
    }
    MatrixXd out(cycle_samples, pressures.cols());
    for (int i = 0; i < cycle_samples; ++i) out.row(i) = series.at(double(i) / cycle_samples).transpose();
    return out;
  }

  /// The hips' height over the planned foot at the sketched angles, for the leading leg until the other heel
  /// strikes.
  double hip_height(double cycles) {
    const double phase = 2 * cycles - std::floor(2 * cycles);
    const LegAngles leg = leg_angles(phase / 2);
    SolidPoses poses(*system_);
    poses.update(0, system_->initial.q);
    const auto at = [&](const char* solid) { return poses.of(solid_index(*system_, solid)).p; };
    const Vector3d hip = at("thigh_right"), knee = at("shank_right"), ankle = at("foot_right");
    const double thigh = (hip - knee).norm(), shank = (knee - ankle).norm();
    return planned_foot(feet_[0], timing_, phase / 2).p.z() + thigh * std::cos(leg.hip) +
           shank * std::cos(leg.hip - leg.knee);
  }

  MatrixXd root_path() {
    MatrixXd pressures(cycle_samples, 2), out(cycle_samples, 3), heights(cycle_samples, 1);
    for (int i = 0; i < cycle_samples; ++i) {
      pressures.row(i) = pressure(double(i) / cycle_samples).transpose();
      heights(i, 0) = hip_height(double(i) / cycle_samples);
    }
    out.leftCols<2>() = sway(pressures);
    const PeriodicSeries rise(heights, 2);  // two peaks a cycle
    for (int i = 0; i < cycle_samples; ++i) out(i, 2) = rise.at(double(i) / cycle_samples)[0] - knee_room;
    return out;
  }

  /// Brings the feet to their places. The root leaves its path where a leg would be too short.
  Result<void> fit_legs(int i, const Vector3d& root, MatrixXd& rows) {
    const double cycles = double(i) / cycle_samples;
    const Vector3d passed(0, timing_.stride() * cycles, 0);
    VectorXd q = sketched_posture(*system_, cycles);
    q.segment<3>(root_) = root;
    SolidPoses poses(*system_);
    poses.update(0, q);
    Matrix3Xd targets(3, std::ssize(fit_.markers()));
    Eigen::Index m = 0;
    for (const auto& [solid, weight] : followed_solids) {
      Pose X = poses.of(solid_index(*system_, solid));
      for (const WalkingFoot& foot : feet_)
        if (foot.solid == solid) {
          X = planned_foot(foot, timing_, cycles);
          X.p += passed;
        }
      for (int k = 0; k < 3; ++k) targets.col(m++) = X * Vector3d(pose_arm * Vector3d::Unit(k));
    }
    const auto frame = fit_.fit(0, targets, VectorXd(), q);
    if (!frame) return tl::unexpected(frame.error());
    rows.row(i) = q.transpose();
    return {};
  }

  MatrixXd smoothed(MatrixXd q) const {
    for (const CoordinateInfo& c : system_->coordinates)
      if (c.q_size == 4)
        for (int i = 1; i < cycle_samples; ++i)
          if (q.block<1, 4>(i, c.q_index).dot(q.block<1, 4>(i - 1, c.q_index)) < 0)
            q.block<1, 4>(i, c.q_index) *= -1;
    const PeriodicSeries series(q, walk_harmonics);
    for (int i = 0; i < cycle_samples; ++i) q.row(i) = series.at(double(i) / cycle_samples).transpose();
    return q;
  }

  /// Centre of pressure that the motion needs, less the planned one.
  MatrixXd pressure_error(const MatrixXd& q) const {
    const PeriodicSeries series(q, walk_harmonics);
    RecordedPositions recorded;
    recorded.q.resize(2 * cycle_samples, system_->nq);
    for (int i = 0; i < 2 * cycle_samples; ++i) {
      recorded.times.push_back((i - cycle_samples / 2) * timing_.cycle / cycle_samples);
      recorded.q.row(i) = positions(series, recorded.times.back()).transpose();
    }
    const auto motion = RecordedMotion::of(*system_, recorded, 0).value();
    RootWrenches wrenches(*system_);
    MatrixXd out(cycle_samples, 2);
    State state;
    VectorXd a;
    for (int i = 0; i < cycle_samples; ++i) {
      const double cycles = double(i) / cycle_samples;
      motion.at(cycles * timing_.cycle, state, a);
      Eigen::Vector2d p = wrenches.needed(state, a).pressure();
      p.y() += timing_.stride() * cycles;
      out.row(i) = (p - pressure(cycles)).transpose();
    }
    return out;
  }

  const System* system_;
  std::array<WalkingFoot, 2> feet_;
  WalkTiming timing_;
  MarkerFit fit_;
  int root_;
};

MarkerMotion markers_of(const System& system, const std::map<std::string, SolidPoint>& places,
                        const RecordedPositions& positions, const SampleWalkOptions& options) {
  MarkerMotion out{{}, positions.times, {}, Vector3d::UnitZ()};
  for (const auto& [name, place] : places) out.names.push_back(name);
  SolidPoses poses(system);
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> noise(0, 1);
  for (std::size_t i = 0; i < positions.times.size(); ++i) {
    poses.update(0, positions.q.row(Eigen::Index(i)).transpose());
    Matrix3Xd frame(3, std::ssize(places));
    Eigen::Index m = 0;
    for (const auto& [name, place] : places) {
      frame.col(m) = poses.of(solid_index(system, place.solid)) * place.point;
      if (options.marker_noise > 0)
        for (int k = 0; k < 3; ++k) frame(k, m) += options.marker_noise * noise(random);
      ++m;
    }
    out.frames.push_back(std::move(frame));
  }
  return out;
}

Result<void> check(const System& system, const std::map<std::string, SolidPoint>& markers,
                   const SampleWalkOptions& o) {
  const bool fine = o.duration > 0 && o.duration < 1000 && o.rate >= 50 && o.rate <= 1000 && o.speed > 0 &&
                    o.cadence > 0 && o.marker_noise >= 0 && o.duration * o.rate >= 3;
  if (!fine)
    return bad_use("sample walk",
                   "needs positive speed and cadence, 50 to 1000 frames a second, at least three of them");
  for (const auto& [name, place] : markers)
    if (solid_index(system, place.solid) < 0)
      return bad_use("sample walk",
                     fmt::format("marker {} is on {}, which the body lacks", name, place.solid));
  return {};
}

/// World (x left, y back, z up) to OpenSim's axes.
Vector3d to_opensim(const Vector3d& p) { return {-p.y(), p.z(), -p.x()}; }

}  // namespace

Result<SampleWalk> sample_walk(const Scene& body, const std::map<std::string, SolidPoint>& markers,
                               const FootSoles& soles, const SampleWalkOptions& options) {
  const auto system = compile(body);
  if (!system) return tl::unexpected(system.error());
  if (auto fine = check(*system, markers, options); !fine) return tl::unexpected(fine.error());
  auto maker = WalkMaker::create(*system, soles, options);
  if (!maker) return tl::unexpected(maker.error());
  const auto cycle = maker->cycle();
  if (!cycle) return tl::unexpected(cycle.error());
  const PeriodicSeries series(*cycle, walk_harmonics);
  SampleWalk walk;
  walk.timing = maker->timing();
  const auto count = Eigen::Index(std::floor(options.duration * options.rate + 1e-9)) + 1;
  walk.positions.q.resize(count, system->nq);
  for (Eigen::Index i = 0; i < count; ++i) {
    walk.positions.times.push_back(double(i) / options.rate);
    walk.positions.q.row(i) = maker->positions(series, walk.positions.times.back()).transpose();
  }
  walk.markers = markers_of(*system, markers, walk.positions, options);
  const auto motion = RecordedMotion::of(*system, walk.positions, 0);
  if (!motion) return tl::unexpected(motion.error());
  auto loads = walk_loads(*system, *motion, walk.positions.times, maker->feet(), walk.timing, soles);
  walk.loads = std::move(loads.loads);
  walk.warnings = std::move(loads.warnings);
  auto efforts = efforts_of(*system, walk.positions, walk.loads, {});
  if (!efforts) return tl::unexpected(efforts.error());
  walk.efforts = std::move(*efforts);
  return walk;
}

MarkerMotion in_opensim_axes(MarkerMotion markers) {
  for (Matrix3Xd& frame : markers.frames)
    for (Eigen::Index m = 0; m < frame.cols(); ++m) frame.col(m) = to_opensim(frame.col(m));
  markers.up = Vector3d::UnitY();
  return markers;
}

MotionTable force_table_of(const std::vector<ExternalLoad>& loads) {
  MotionTable table{"ground forces", {}, {}, {}, false};
  if (loads.empty()) return table;
  table.times = loads.front().measured.times;
  table.values.setZero(std::ssize(table.times), 9 * std::ssize(loads));
  Eigen::Index column = 0;
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const std::string plate = l == 0 ? "" : fmt::format("{}_", l);
    const MeasuredForce& measured = loads[l].measured;
    for (const auto& [name, values] :
         {std::pair{"ground_force_v", &measured.force}, std::pair{"ground_force_p", &measured.point},
          std::pair{"ground_torque_", &measured.moment}}) {
      for (const char* axis : {"x", "y", "z"}) table.columns.push_back(plate + name + axis);
      for (Eigen::Index i = 0; i < values->cols(); ++i)
        if (measured.point.col(i).allFinite())
          table.values.block<1, 3>(i, column) = to_opensim(values->col(i)).transpose();
      column += 3;
    }
  }
  return table;
}

}  // namespace borelli
