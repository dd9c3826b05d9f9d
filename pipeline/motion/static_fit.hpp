// Fits a model to a standing trial: scale factors of its segments, places of its markers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "pipeline/recordings/marker_motion.hpp"

namespace borelli {

struct StaticFitRequest {
  bool per_segment = false;            ///< a factor for each solid; false: one for the whole model
  std::optional<double> mass;          ///< kg, of the whole body; empty: masses scale with volume
  bool move_markers = true;            ///< move the model's markers to their places in the trial
  Eigen::VectorXd rest_weights = {};   ///< as MarkerFitSettings::rest_weights
  double start = -1e300, end = 1e300;  ///< s, of the frames whose mean is taken
};

struct StaticFit {
  Scene scene;                  ///< scaled; its coordinates start in the trial's pose
  std::vector<double> factors;  ///< per solid of the scene
  double mass = 0;              ///< kg
  double rms_before = 0;        ///< m, marker errors of the unscaled model in its best pose
  double rms_after = 0;         ///< m, of the scaled model, before its markers are moved
  std::vector<std::string> warnings;
};

/// A trial as one frame at time 0: each marker's mean over the frames from start to end (s) that show it.
MarkerMotion mean_frame(const MarkerMotion& trial, double start, double end);

/// Factors s and pose q minimise
///   sum_m |x_m(q, s) - y_m|^2 / sigma^2 + sum_b (s_b - g)^2 / (10 %)^2
/// over the markers that model and trial share; y_m is the mean place of marker m. g is the whole body's
/// factor, which segments with too few markers follow. sigma is the root mean square of the marker errors, at
/// least 1 cm, so that segments do not stretch to hide a difference in shape. At a given pose marker places
/// are linear in s: least squares in s alternate with fits of the pose (marker_fit.hpp) until no factor
/// changes by 1e-6. Errors: as fit_motion, fewer than three markers in the trial, a factor that is not
/// between 0.2 and 5.
Result<StaticFit> fit_static(const Scene& scene, const MarkerMotion& trial, const StaticFitRequest& request);

}  // namespace borelli
