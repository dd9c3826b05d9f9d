// Estimates a scan's noise from the scan itself.
#pragma once

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Standard deviation of the noise within the labels, in grey values, from second differences along rows, as
/// for white noise:
/// median(|v0 - 2 v1 + v2|) / (0.6745 sqrt 6)
/// Differences beyond three deviations are excluded iteratively. Returns 0 if most neighbours are equal or
/// fewer than 100 differences remain.
double estimate_noise(const GreyVolume& volume, const LabelMap& labels);

}  // namespace borelli
