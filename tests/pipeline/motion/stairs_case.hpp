// A person walks down a stair over four force plates (Movement_trial.c3d and Static_trial.c3d, public sample
// data of pyCGM). The phantom, scaled to the person, gives flexion and moments of hips and knees. They are
// compared with those that the capture system (Vicon Nexus, Plug-in Gait) stored in the file.
//
// The file also stores the axes of each bone: A forwards, L to the left, P up. If R = Ry(a) Rx(b) Rz(c)
// rotates a bone relative to the one above it, the stored flexion is -a at the hip and a at the knee, to
// rounding.
//
// Plug-in Gait defines its axes differently. It turns the thighs by 40 degrees about their length, as its own
// hip rotation shows, so that 50 degrees of knee flexion appear as abduction and rotation. We therefore
// rotate the axes of each of our segments once, by the mean rotation to the stored bone over the motion. Then
// flexion is read from both in the same way.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "pipeline/motion/foot_contact.hpp"
#include "pipeline/motion/marker_calibration.hpp"
#include "pipeline/motion/marker_placement.hpp"
#include "pipeline/motion/scaled_scene.hpp"
#include "pipeline/motion/static_fit.hpp"
#include "pipeline/recordings/c3d_file.hpp"
#include "tests/pipeline/motion/phantom_recording.hpp"

namespace borelli::test {

/// Ours and theirs at the same times; deg, or N m with extension positive.
struct StairsCurve {
  std::string name;
  std::vector<double> times, ours, theirs;

  double rms() const {
    double squares = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) squares += (ours[i] - theirs[i]) * (ours[i] - theirs[i]);
    return std::sqrt(squares / double(ours.size()));
  }
  double correlation() const {
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    const auto n = double(ours.size());
    for (std::size_t i = 0; i < ours.size(); ++i) {
      a += ours[i], b += theirs[i];
      aa += ours[i] * ours[i], bb += theirs[i] * theirs[i], ab += ours[i] * theirs[i];
    }
    return (ab - a * b / n) / std::sqrt((aa - a * a / n) * (bb - b * b / n));
  }
};

class StairsCase {
 public:
  explicit StairsCase(const std::string& folder, bool calibrate)
      : trial_(mean_frame(taken(read_c3d(folder + "Static_trial.c3d")).markers, -1e300, 1e300)),
        file_(taken(read_c3d(folder + "Movement_trial.c3d"))) {
    const Phantom phantom = build_phantom({}).value();
    const Scene body = still_body(exact_parts(phantom), phantom.landmarks);
    const BodyMarkers markers =
        body_markers(trial_.names, phantom.landmarks, segments_of(body), PointKind::markers);
    Scene placed = taken(place_markers(body, markers.markers, trial_, {true, true})).scene;
    if (calibrate) placed = taken(calibrated_markers(placed, file_.markers)).scene;
    const auto fit = taken(fit_placed(placed, file_.markers));
    marker_error = fit.rms();
    // knees are balls, so that their moments have three components; the person's mass
    constexpr double person = 85;  // kg, PROCESSING:Bodymass
    const std::vector<double> same(placed.solids.size(), 1);
    scene_ = scaled(placed, same, person / total_mass(placed).value()).scene;
    const System hinged = taken(compile(scene_));
    make_balls();
    positions_ = {fit.times, as_balls(hinged, fit.q)};
    for (std::size_t f = 0; frames_.size() < fit.times.size(); ++f)
      if (std::abs(file_.markers.times[f] - fit.times[frames_.size()]) < 1e-9) frames_.push_back(f);
  }

  double marker_error = 0;  ///< m, rms of the fit

  /// Flexion of hips and knees, deg.
  std::vector<StairsCurve> flexions() const {
    std::map<std::string, Eigen::Matrix3d> R_SB;  // of each segment
    for (const auto& [segment, name] : bones_) R_SB[segment] = bone_in_segment(segment);
    std::vector<StairsCurve> out;
    SolidPoses poses(system_);
    for (const Joint& joint : joints_) {
      StairsCurve curve{joint.name, {}, {}, {}};
      for (std::size_t i = 0; i < frames_.size(); ++i) {
        poses.update(0, positions_.q.row(Eigen::Index(i)).transpose());
        const auto ours = [&](const std::string& segment) -> Eigen::Matrix3d {
          return axes(poses, segment) * R_SB.at(segment);
        };
        const auto theirs = [&](const std::string& segment) { return bone(segment, frames_[i]); };
        const Eigen::Matrix3d R_ours = ours(joint.upper).transpose() * ours(joint.lower),
                              R_theirs = theirs(joint.upper).transpose() * theirs(joint.lower);
        curve.times.push_back(positions_.times[i]);
        curve.ours.push_back(joint.sign * about_left(R_ours));
        curve.theirs.push_back(joint.sign * about_left(R_theirs));
      }
      out.push_back(std::move(curve));
    }
    return out;
  }

  /// The stored angle of a joint, deg, at the fitted times.
  std::vector<double> stored_angle(const std::string& joint) const {
    return stored(joints_[index(joint)].output + "Angles", 1);
  }

  /// Extension moments of hips and knees, N m, about the lower bone's axis L, during the steps whose ground
  /// force the file has (one of two steps of each foot).
  std::vector<StairsCurve> moments() const {
    const RecordedMotion motion = taken(RecordedMotion::of(system_, positions_, 6));
    const FootLoads loads = taken(loads_on_feet(system_, motion, file_.forces, feet_of(system_)));
    MotionEffortsRequest asked;
    asked.cutoff = 6;
    const RecordedEfforts efforts = taken(efforts_of(system_, positions_, loads.loads, asked));
    std::vector<StairsCurve> out;
    SolidPoses poses(system_);
    for (const Joint& joint : joints_) {
      StairsCurve curve{joint.name, {}, {}, {}};
      const auto c = std::ranges::find(system_.coordinates, joint.coordinate, &CoordinateInfo::name);
      constexpr double to_newton_metres = 85e-3;  // of N mm/kg
      const auto theirs = stored(joint.output + "Moment", to_newton_metres);
      const auto ground =
          stored(joint.name.substr(joint.name.find(' ') + 1) == "left" ? "LGroundReactionForce"
                                                                       : "RGroundReactionForce",
                 1, 2);
      for (std::size_t i = 0; i < frames_.size(); ++i) {
        if (!(ground[i] > 0 && std::isfinite(theirs[i]))) continue;  // NaN: the file has none
        poses.update(0, efforts.q.row(Eigen::Index(i)).transpose());
        const Eigen::Vector3d tau = efforts.efforts.row(Eigen::Index(i)).segment<3>(c->v_index).transpose();
        const Eigen::Vector3d moment = axes(poses, joint.lower) * after_ball(joint.lower).transpose() * tau;
        curve.times.push_back(positions_.times[i]);
        curve.ours.push_back(-joint.sign * moment.dot(bone(joint.lower, frames_[i]).col(1)));
        curve.theirs.push_back(theirs[i]);
      }
      out.push_back(std::move(curve));
    }
    return out;
  }

 private:
  struct Joint {
    std::string name, coordinate, upper, lower, output;
    double sign;  ///< of flexion about the axis L
  };

  template <class T>
  static T taken(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message());
    return std::move(*result);
  }

  std::size_t index(const std::string& joint) const {
    return std::size_t(std::ranges::find(joints_, joint, &Joint::name) - joints_.begin());
  }

  /// World from a stored bone: columns A, L, P.
  Eigen::Matrix3d bone(const std::string& segment, std::size_t frame) const {
    const auto point = [&](char end) -> Eigen::Vector3d {
      const auto& names = file_.markers.names;
      const auto column = std::ranges::find(names, bones_.at(segment) + end) - names.begin();
      return file_.markers.frames[frame].col(column);
    };
    Eigen::Matrix3d R;
    R << (point('A') - point('O')).normalized(), (point('L') - point('O')).normalized(),
        (point('P') - point('O')).normalized();
    return R;
  }

  Eigen::Matrix3d axes(const SolidPoses& poses, const std::string& segment) const {
    return poses.of(solid_index(system_, segment)).R;
  }

  /// The mean over the motion (the rotation nearest to the mean of the matrices).
  Eigen::Matrix3d bone_in_segment(const std::string& segment) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    SolidPoses poses(system_);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      poses.update(0, positions_.q.row(Eigen::Index(i)).transpose());
      sum += axes(poses, segment).transpose() * bone(segment, frames_[i]);
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> parted(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return parted.matrixU() * parted.matrixV().transpose();
  }

  /// The first angle of R = Ry Rx Rz, deg.
  static double about_left(const Eigen::Matrix3d& R) {
    return std::atan2(R(0, 2), R(2, 2)) * 180 / std::numbers::pi;
  }

  std::vector<double> stored(const std::string& name, double factor, Eigen::Index row = 0) const {
    const auto output = std::ranges::find(file_.outputs, name, &ModelOutput::name);
    std::vector<double> out;
    for (const std::size_t f : frames_) out.push_back(factor * output->values(row, Eigen::Index(f)));
    return out;
  }

  void make_balls() {
    for (Solid& solid : scene_.solids)
      for (Switch& one : solid.switches)
        if (solid.name.starts_with("shank") && std::holds_alternative<Rotation>(one.kind)) {
          hinges_[one.coordinate] = std::get<Rotation>(one.kind).axis;
          one.kind = Ball{};
          one.q.clear();
          one.ranges.clear();
        }
    system_ = taken(compile(scene_));
  }

  Rows as_balls(const System& hinged, const Rows& q) const {
    Rows out(q.rows(), system_.nq);
    for (const CoordinateInfo& c : system_.coordinates) {
      const auto from = std::ranges::find(hinged.coordinates, c.name, &CoordinateInfo::name);
      const auto hinge = hinges_.find(c.name);
      for (Eigen::Index i = 0; i < q.rows(); ++i) {
        if (hinge == hinges_.end()) {
          out.row(i).segment(c.q_index, c.q_size) = q.row(i).segment(from->q_index, c.q_size);
          continue;
        }
        const double half = q(i, from->q_index) / 2;
        out.row(i).segment<4>(c.q_index) << std::cos(half), std::sin(half) * hinge->second.transpose();
      }
    }
    return out;
  }

  /// R of the fixed switches behind a solid's ball: from the ball's moving axes to the solid's.
  Eigen::Matrix3d after_ball(const std::string& segment) const {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    const auto solid = std::ranges::find(scene_.solids, segment, &Solid::name);
    for (const Switch& one : solid->switches) {
      if (std::holds_alternative<Ball>(one.kind)) R.setIdentity();
      if (const auto* fixed = std::get_if<Fixed>(&one.kind)) R = R * fixed->X_AB.R;
    }
    return R;
  }

  const std::map<std::string, std::string> bones_{{"lower_trunk", "PEL"},
                                                  {"thigh_left", "LFE"},
                                                  {"thigh_right", "RFE"},
                                                  {"shank_left", "LTI"},
                                                  {"shank_right", "RTI"}};
  const std::vector<Joint> joints_{{"hip left", "hip_left", "lower_trunk", "thigh_left", "LHip", -1},
                                   {"hip right", "hip_right", "lower_trunk", "thigh_right", "RHip", -1},
                                   {"knee left", "knee_left", "thigh_left", "shank_left", "LKnee", 1},
                                   {"knee right", "knee_right", "thigh_right", "shank_right", "RKnee", 1}};
  MarkerMotion trial_;
  C3dFile file_;
  Scene scene_;
  System system_;
  std::map<std::string, Eigen::Vector3d> hinges_;
  RecordedPositions positions_;
  std::vector<std::size_t> frames_;  ///< of the file, per fitted time
};

}  // namespace borelli::test
