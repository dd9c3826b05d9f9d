// A label map that the user brings, in place of a segmentation.
#pragma once

#include "segmentation/segment.hpp"

namespace borelli {

/// The parts that the labels name, with their volumes: cut where they reach the grid's border, else whole;
/// absent without voxels. Confidence is 1, since the user vouches for them.
Segmentation segmentation_of(LabelMap labels, Landmarks landmarks);

}  // namespace borelli
