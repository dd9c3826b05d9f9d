// A scan whose truth is known: what a score holds a segmentation against, whatever made the body.
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
  bool stump = false;    ///< ends early in the body itself: neither cut nor whole is wrong
  double share = 0;      ///< of its mass that is in the scan
  Inertial whole, seen;  ///< of all of it, and of what is in the scan; patient axes, m
};

struct TrueScan {
  GreyVolume grey;
  LabelMap labels;      ///< by deleva1996's planes at the exact landmarks
  LabelMap bones;       ///< by whose bone a voxel is, 0 of flesh; empty if the source tells none
  Landmarks landmarks;  ///< those that the body still has, in the scan or not; mm
  std::array<PartTruth, parts.size()> part;
  double overlap = 0;  ///< of limbs that go through each other, mm^3
  std::string what;    ///< one line
  std::vector<std::string> kinds;
};

}  // namespace borelli::suite
