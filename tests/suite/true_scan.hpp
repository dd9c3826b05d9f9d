// A scan with known truth, against which a segmentation is scored.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "inertia/inertial.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli::suite {

struct PartTruth {
  Coverage coverage =
      Coverage::absent;  ///< whole: 98 % or more of its mass is in the scan; absent: 0.2 % or less
  bool stump = false;    ///< ends early in the body itself; both cut and whole are right
  double share = 0;      ///< share of its mass in the scan
  Inertial whole, seen;  ///< of the whole part and of its piece in the scan; patient axes, m
};

struct TrueScan {
  GreyVolume grey;
  LabelMap labels;      ///< by deleva1996's planes at the exact landmarks
  LabelMap bones;       ///< the part of each bone voxel, 0 for flesh; empty if the source has none
  Landmarks landmarks;  ///< all that the body has, in the scan or not; mm
  std::array<PartTruth, parts.size()> part;
  double overlap = 0;  ///< intersection of limbs, mm^3
  std::string what;    ///< one line
  std::vector<std::string> kinds;
};

}  // namespace borelli::suite
