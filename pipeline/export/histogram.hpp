// How often each grey value occurs in a scan: in all of it, and in the labelled body.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

struct Histogram {
  int low = 0;    ///< the least grey value of the first bin
  int width = 1;  ///< grey values per bin; bin b holds low + b width and the width - 1 values above
  std::vector<std::uint64_t> all;      ///< voxels per bin
  std::vector<std::uint64_t> body;     ///< of them labelled; empty where no labels lie on the scan's grid
  std::uint64_t below = 0, above = 0;  ///< voxels of `all` outside the bins
};

/// Counts every voxel once. The bins, at most `most_bins` of 1, 2 or 5 times a power of ten, hold the values
/// but for 1 in 100 000 voxels at either end (a few stray ones would make the rest narrow).
Histogram histogram(const GreyVolume& grey, const LabelMap* labels, int most_bins = 320, int threads = 0);

}  // namespace borelli
