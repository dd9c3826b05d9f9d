// How loud a scan's noise is, from the scan itself.
#pragma once

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Standard deviation of the noise within the labels, from second differences along rows, as for white noise:
/// median(|v0 - 2 v1 + v2|) / (0.6745 sqrt 6) of those within three deviations. Grey values; 0 where most
/// neighbours are equal.
double estimate_noise(const GreyVolume& volume, const LabelMap& labels);

}  // namespace borelli
