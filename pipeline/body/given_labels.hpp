// A label map that the user brings, in place of a segmentation.
#pragma once

#include "pipeline/body/belonging.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// The parts that the labels name, with their volumes: cut as cut_labels says, else whole; absent without
/// voxels. Confidence is 1, since the user vouches for them. `scan` lies on the labels' grid.
Segmentation segmentation_of(LabelMap labels, Landmarks landmarks, const GreyVolume& scan, int threads);

/// Notes what of the labels lies in air; parts with much of it are cut, and nobody vouches for them.
void doubt_what_is_air(const LabelsInAir& air, Segmentation& found);

}  // namespace borelli
