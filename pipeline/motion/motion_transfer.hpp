// Transfers another person's motion to a body: joint angles stay, path and forces scale to its size, and its
// feet are set on the ground.
#pragma once

#include <vector>

#include "error/error.hpp"
#include "pipeline/motion/captured_motion.hpp"

namespace borelli {

/// Replaces the recorded person's sized model, fit and loads in `motion` by those of the body. `factors`:
/// size of the sized model over the body, per solid.
///   path    Joint angles stay. The root's path scales with the length of the legs; its height counts from the
///           lowest sole point of the recording.
///   stance  A sole point stands while it is within 15 mm of its lowest height (the mean level of its lowest
///           tenth of frames) and slower than 0.3 m/s, for at least 0.1 s. A standing foot is held in one flat
///           pose, its soles at height 0: the mean pose of the frames in which most of its points stand. Least
///           squares brings it there. No sole point goes below 0.
///   stairs  A foot that carries a measured load at least 5 cm above that lowest height stands on a step: there
///           heights count from the lowest ones during the load. Steps scale with the length of the legs.
///   forces  They scale with the mass, and act at the same place of the foot, at the height of its floor.
///           The recorded mass, if it is not given, is the upper quartile of F_z / (g + a_z) over the samples
///           with at least half of the largest F_z; a_z is the gravity centre's acceleration. (A foot beside
///           the plates makes F_z too small, so lower values are not used.)
Result<void> transfer_motion(CapturedMotion& motion, const BodyModel& body,
                             const std::vector<double>& factors, const CapturedMotionRequest& request);

}  // namespace borelli
