// Detects values clipped to a display window, as viewers and 8-bit pictures do. Air, fat or bone then share
// one value, and their densities cannot be recovered.
#pragma once

#include <cstdint>
#include <string>

#include "segmentation/files/value_counts.hpp"

namespace borelli {

struct DisplayWindow {
  std::int16_t least = 0, greatest = 0;  ///< of all measured voxels
  double at_least = 0, at_greatest = 0;  ///< shares of voxels with exactly that value
  bool low_cut = false;                  ///< values below `least` were clipped to it: no air is left
  bool high_cut = false;                 ///< values above `greatest` were clipped to it: bone is capped
};

/// Judges CT numbers. Says nothing about volumes with few different values (drawn bodies, water in air).
DisplayWindow display_window(const ValueCounts& counts);

/// A sentence without subject on what to do about a low cut: "cannot hold CT numbers: ...".
std::string advice_on(const DisplayWindow& window);

}  // namespace borelli
