// Places a recording's markers on a body, and fits the body to the recording.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/system.hpp"
#include "pipeline/motion/body_markers.hpp"
#include "pipeline/motion/motion_fit.hpp"
#include "pipeline/recordings/marker_motion.hpp"

namespace borelli {

/// Rest weights of a body's joints (MarkerFitSettings), one per velocity component. A joint that has moved by
/// `share` times its published range from the start costs as much as one of `markers` markers that is off by
/// 1 cm. A joint without a published range is given 2 rad. For arms `share` is at least 1/4. Coordinates of
/// bodies that hang on the world have weight 0.
Eigen::VectorXd body_rest_weights(const System& system, std::size_t markers, double share);

struct PlacementRequest {
  bool size_to_trial = false;  ///< the trial shows another person: scale the segments first (static_fit.hpp)
  /// The person stands still, upright: joints are near the anatomical position. Otherwise they may be
  /// anywhere about the scene's start.
  bool standing = false;
};

struct PlacedMarkers {
  Scene scene;                   ///< with all markers; starts in the trial's pose
  std::vector<double> factors;   ///< per solid, of its size; 1 unless sized to the trial
  double landmark_distance = 0;  ///< m, rms of the markers from their landmarks in the trial's pose
  std::vector<std::string> warnings;
};

/// Fits the scene's pose to the markers over landmarks, then moves every marker to its place in the trial,
/// each on its own segment. `markers` gives points in the world of the scene's start; `trial` is one frame, z
/// up. Rest weights hold joints near the start, or near the anatomical position if the person stands. Their
/// share is 5/4. It is 1/16 for another person who stands: there the distance of a marker from its landmark
/// shows another shape, not another pose. Errors: fewer than three markers over landmarks; as compile and
/// fit_motion.
Result<PlacedMarkers> place_markers(const Scene& scene, const std::vector<BodyMarker>& markers,
                                    const MarkerMotion& trial, const PlacementRequest& request);

/// Fits a scene that starts in the trial's pose to every frame of a recording. First the whole body is moved
/// rigidly onto the markers of the first frame, which may be far from the trial.
Result<MotionFit> fit_placed(const Scene& scene, const MarkerMotion& motion,
                             const std::function<void(double)>& progress = {});

}  // namespace borelli
