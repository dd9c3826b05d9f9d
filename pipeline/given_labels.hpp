// A label map that the user brings, in place of a segmentation.
#pragma once

#include "segmentation/segment.hpp"

namespace borelli {

/// The parts that the labels name, with their volumes: cut as cut_labels says, else whole; absent without
/// voxels. Confidence is 1, since the user vouches for them. `scan` lies on the labels' grid.
Segmentation segmentation_of(LabelMap labels, Landmarks landmarks, const GreyVolume& scan, int threads);

}  // namespace borelli
