// Label maps that the user supplies instead of a segmentation.
#pragma once

#include "pipeline/body/belonging.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Parts named by the labels, with their volumes. A part is cut if cut_labels says so, otherwise whole;
/// without voxels it is absent. Confidence is 1, since the user vouches for the labels. `scan` lies on the
/// labels' grid.
Segmentation segmentation_of(LabelMap labels, Landmarks landmarks, const GreyVolume& scan, int threads);

/// Notes which labels lie in air. A part with much of it in air becomes cut and loses its confidence of 1.
void doubt_what_is_air(const LabelsInAir& air, Segmentation& found);

}  // namespace borelli
