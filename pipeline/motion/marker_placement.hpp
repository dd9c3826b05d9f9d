// Places a recording's markers on a body, and fits the body to the recording.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/system.hpp"
#include "pipeline/motion/body_markers.hpp"
#include "pipeline/motion/marker_motion.hpp"
#include "pipeline/motion/motion_fit.hpp"

namespace borelli {

/// Rest weights (MarkerFitSettings) of a body's pose, per velocity component: a joint that is `share` of
/// its published range away from the start counts like one of `markers` markers that is 1 cm away, a skin's usual
/// shift. Joints without a range: 2 rad. Arms: at least 1/4. What hangs on the world: 0.
Eigen::VectorXd body_rest_weights(const System& system, std::size_t markers, double share);

struct PlacementRequest {
  bool size_to_trial = false;  ///< the trial shows another person: scale the segments first (static_fit.hpp)
  /// The person stands still, upright: joints are near the anatomical position. Otherwise they may be anywhere
  /// about the scene's start.
  bool standing = false;
};

struct PlacedMarkers {
  Scene scene;                         ///< with all markers; starts in the trial's pose
  std::vector<double> factors;         ///< per solid, of its size; 1 unless sized to the trial
  double landmark_distance = 0;        ///< m, rms of the markers from their landmarks in the trial's pose
  std::vector<std::string> followers;  ///< markers that stand over no landmark
  std::vector<std::string> warnings;
};

/// Brings the scene into the trial's pose by the markers over landmarks, then moves all markers to where the trial
/// shows them, each on its segment. Points of `markers` are in the world of the scene's start. `trial`: one
/// frame, z up. Joints are drawn to the anatomical position or the start with the share 5/4 (body_rest_weights);
/// those of another person who stands with 1/16, since there a marker's distance from the landmark is the
/// other shape rather than another pose. Errors: fewer than
/// three markers over landmarks; as compile and fit_motion.
Result<PlacedMarkers> place_markers(const Scene& scene, const std::vector<BodyMarker>& markers,
                                    const MarkerMotion& trial, const PlacementRequest& request);

/// Fits a scene that starts in the trial's pose to a recording that may begin elsewhere: the whole body is first
/// laid onto the first frame's markers.
Result<MotionFit> fit_placed(const Scene& scene, const MarkerMotion& motion,
                             const std::function<void(double)>& progress = {});

}  // namespace borelli
