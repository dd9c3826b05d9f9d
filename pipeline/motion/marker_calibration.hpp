// Finds the markers' places on a body from the motion itself.
#pragma once

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"
#include "pipeline/recordings/marker_motion.hpp"

namespace borelli {

struct CalibratedMarkers {
  Scene scene;                           ///< with the markers at their new places
  double rms_before = 0, rms_after = 0;  ///< m, marker errors over the frames that were used
};

/// Minimises sum |X_S(q_f) m - y_f|^2 over the places m of all markers in their solids and the positions q_f
/// of the frames f: a fit of each frame and the mean of each marker's places in its solid alternate, with
/// Anderson's acceleration, until these means differ from the places by less than 0.02 mm, 150 times at most,
/// over at most 64 frames spread over the motion. Joint centres and segments keep their places, so the result
/// also places the markers relative to the joints. Angles that the motion does not determine (a constant
/// offset of a joint that hardly moves) stay near the start of `scene`, by the rest weights of fit_placed.
/// `scene` starts in the trial's pose with its markers placed (place_markers). After Reinbolt JA et al (2005)
/// J Biomech 38:621 and Werling K et al (2023) PLoS ONE 18:e0295152, who also free the segments' sizes.
/// Errors: as fit_placed.
Result<CalibratedMarkers> calibrated_markers(const Scene& scene, const MarkerMotion& motion);

}  // namespace borelli
