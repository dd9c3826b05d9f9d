// Standard deviations of joint moments. They come from draws of the inertia table, the joint centres and the
// markers, each carried through the whole computation from markers to moments.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "inertia/table.hpp"
#include "pipeline/motion/captured_motion.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// The measurements that the body was made from. Each draw changes them and makes the body again.
struct BodySource {
  const InertiaTable& table;  ///< with deviations
  const Landmarks& landmarks;
  PointKind kind = PointKind::markers;  ///< as for body_markers
  const JointMapping& own_markers;      ///< likewise
};

struct EffortBandRequest {
  int samples = 24;   ///< per cause; deviations are then known within 1 / sqrt(2 samples), 14 %
  double cutoff = 6;  ///< Hz, as that of the motion
  unsigned seed = 1;
  int threads = 0;
  std::function<void(double)> progress;  ///< share done, 0 to 1; called by one thread at a time
};

struct EffortBands {
  std::vector<std::string> causes;  ///< "masses"; of a motion with markers also "joint centres", "markers"
  Rows deviation;                   ///< #times by nv, N m or N: standard deviation of the effort, all causes
  std::vector<Rows> by_cause;       ///< the same of each cause alone
  int failed = 0;                   ///< draws that could not be computed, left out
};

/// Draws each cause alone and adds the variances, as those of independent errors:
///   masses         mass, gravity centre and tensor of each part by its deviations, those by the density curve
///                  alike in all parts, the others independently. An impossible inertia is drawn
///                  again, up to 20 times; then the part keeps its own
///   joint centres  each landmark by its deviation along each axis; the body is built again, the markers are
///                  placed on it again (and calibrated, if they were), and the motion is fitted again
///   markers        each marker is shifted on its segment by its own rms error in the fit, and the motion is
///                  fitted again
/// The same seed gives the same bands on any number of threads. Errors: a table without deviations, more than
/// a quarter of the draws failed.
Result<EffortBands> effort_bands(const CapturedMotion& motion, const BodySource& source,
                                 const EffortBandRequest& request);

}  // namespace borelli
