// Inverse kinematics of a whole recording: a model's positions at every frame of its markers.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/inverse/marker_fit.hpp"
#include "dynamics/scene/scene.hpp"
#include "pipeline/recordings/ik_setup.hpp"
#include "pipeline/recordings/marker_motion.hpp"
#include "pipeline/recordings/motion_table.hpp"

namespace borelli {

struct MotionFitRequest {
  /// The tasks; none: all markers that model and recording share, with weight 1.
  std::optional<InverseKinematicsSetup> setup;
  std::optional<MotionTable> coordinate_values;  ///< of tasks `from_file`
  std::pair<double, double> time_range{-std::numeric_limits<double>::infinity(),
                                       std::numeric_limits<double>::infinity()};
  Eigen::VectorXd rest_weights = {};     ///< as MarkerFitSettings::rest_weights
  std::function<void(double)> progress;  ///< called with the share done, 0 to 1; may be empty
};

struct MotionFit {
  std::vector<double> times;         ///< s, of the frames with a marker
  Rows q;                            ///< #times by nq
  std::vector<std::string> markers;  ///< those that were followed
  Rows errors;                       ///< #times by #markers, m; NaN where a marker was not seen
  std::vector<MarkerFrame> frames;   ///< per time
  std::size_t left_out = 0;          ///< frames within the time range that show no marker to follow
  std::vector<std::string> warnings;

  double rms() const;  ///< m, root mean square over all frames and seen markers
};

/// Fits frame after frame, each from the one before. The first starts from the scene's initial positions and,
/// if the fit stays far from the markers, from other orientations of the root bodies. Measured axes are
/// turned to the scene's if the recording tells which way is up. Errors: no marker that the model has, no
/// frame within the range, tasks for coordinates that the model does not have, constraints that cannot hold.
Result<MotionFit> fit_motion(const Scene& scene, const System& system, const MarkerMotion& recording,
                             const MotionFitRequest& request);

/// Says that markers lie too far from a model's: with a root mean square error, m, of more than 8 % of the
/// markers' spread in the recording. Empty otherwise.
std::string misfit(double rms, const MarkerMotion& recording);

/// The turn from a recording's axes to the scene's: the smallest that brings `up` (unit, in the recording's
/// axes) against gravity. Identity without `up` or gravity.
Eigen::Matrix3d turn_to_scene(const Scene& scene, const std::optional<Eigen::Vector3d>& up);

/// The fit as a table with a column for each coordinate (four for a ball, its quaternion's w, x, y, z),
/// angles in degrees.
MotionTable table_of(const System& system, const MotionFit& fit);

/// Per frame: sum of squares (m^2), root mean square, largest error (m), then each marker's error (m), with
/// the first three columns named as OpenSim names them.
MotionTable error_table_of(const MotionFit& fit);

}  // namespace borelli
