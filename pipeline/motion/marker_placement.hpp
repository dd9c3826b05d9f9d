// Places a recording's markers on a body, and fits the body to the recording.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "pipeline/motion/body_markers.hpp"
#include "pipeline/motion/marker_motion.hpp"
#include "pipeline/motion/motion_fit.hpp"

namespace borelli {

/// Weight of the start in fits of a body's pose (MarkerFitSettings::rest_weight): a joint that is half a radian
/// away, as in usual movements, counts like one of `markers` markers that is 1 cm away, a skin's usual shift.
double body_rest_weight(std::size_t markers);

struct PlacedMarkers {
  Scene scene;                         ///< with all markers; starts in the trial's pose
  std::vector<double> factors;         ///< per solid, of its size; 1 unless sized to the trial
  double landmark_distance = 0;        ///< m, rms of the markers from their landmarks in the trial's pose
  std::vector<std::string> followers;  ///< markers that stand over no landmark
  std::vector<std::string> warnings;
};

/// Brings the scene, from its start, into the trial's pose by the markers over landmarks, then moves all markers
/// to where the trial shows them, each on its segment. Points of `markers` are in the world of the scene's start.
/// `trial`: one frame, z up. `size_to_trial`: scales the segments first (static_fit.hpp). Errors: fewer than
/// three markers over landmarks; as compile and fit_motion.
Result<PlacedMarkers> place_markers(const Scene& scene, const std::vector<BodyMarker>& markers,
                                    const MarkerMotion& trial, bool size_to_trial);

/// Fits a scene that starts in the trial's pose to a recording that may begin elsewhere: the whole body is first
/// laid onto the first frame's markers.
Result<MotionFit> fit_placed(const Scene& scene, const MarkerMotion& motion,
                             const std::function<void(double)>& progress = {});

}  // namespace borelli
