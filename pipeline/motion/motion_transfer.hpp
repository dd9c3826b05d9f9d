// Another person's motion on a body: angles kept, way and forces to its size, feet set down on the ground.
#pragma once

#include <vector>

#include "error/error.hpp"
#include "pipeline/motion/captured_motion.hpp"

namespace borelli {

/// `motion` holds the recorded person's sized model, its fit and its loads; afterwards it holds the body's.
/// `factors`: of the sized model's solids to the body's.
///
/// Angles stay. Lengths of the way scale with the legs; heights count from the level of the lowest sole point. A
/// sole point stands while it is within 15 mm of the height that it has in the lowest tenth of the recording and
/// slower than 0.3 m/s, for at least 0.1 s: there the foot is held by least squares in the flat pose that it
/// has while most of its points stand, its soles at height 0; no sole point goes below 0. Forces scale with the
/// mass and act at the same place of the foot, at height 0. The recorded mass, if not told, is the upper
/// quartile of F_z / (g + a_z) over the samples of at least half of the largest F_z, where a is that of the
/// gravity centre: smaller values come from a foot beside the plates.
Result<void> transfer_motion(CapturedMotion& motion, const BodyModel& body,
                             const std::vector<double>& factors, const CapturedMotionRequest& request);

}  // namespace borelli
