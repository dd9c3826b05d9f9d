// The low-pass filter of motion analysis: a Butterworth filter of third order, run forwards and backwards so
// that it shifts nothing in time.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct SampledSignal {
  std::vector<double> times;  ///< s, evenly spaced
  Eigen::MatrixXd values;     ///< #times by #columns
};

/// The signal below `cutoff` (Hz; each of the two runs damps it to 1 / sqrt 2 there). It follows OpenSim's
/// inverse dynamics (Storage::pad, Storage::lowpassIIR). Half as many samples are added before and after,
/// reflected about the end points (odd padding), so that value and slope continue. Samples at uneven times
/// are then resampled at the smallest step through a quintic spline. The result covers the padded time.
/// Errors: fewer than five samples, times that do not increase, a cut-off that is not positive or at least
/// half of the sampling rate.
Result<SampledSignal> low_pass(const SampledSignal& signal, double cutoff);

}  // namespace borelli
