// Whether a volume's values were cut off at the ends of a display window, as viewers and 8-bit pictures do:
// air, fat or bone then have one value, and no reading gives their density back.
#pragma once

#include <cstdint>
#include <string>

#include "segmentation/volume/volume.hpp"

namespace borelli {

struct DisplayWindow {
  std::int16_t least = 0, greatest = 0;  ///< of all voxels that were seen
  double at_least = 0, at_greatest = 0;  ///< shares of these that have just that value
  bool low_cut = false;                  ///< what lies below `least` has its value: no air is left
  bool high_cut = false;  ///< what lies above `greatest` has its value: bone is no denser than that
};

/// CT numbers alone can be told of: values of a volume whose quantity is hu. Of few different values (drawn
/// bodies, water in air) nothing is said.
DisplayWindow display_window(const GreyVolume& volume);

/// A sentence without subject on what to do about a low cut: "cannot hold CT numbers: ...".
std::string advice_on(const DisplayWindow& window);

}  // namespace borelli
