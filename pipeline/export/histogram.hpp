// Histogram of a scan's grey values: of the whole scan, and of the labelled body.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

struct Histogram {
  int low = 0;    ///< smallest grey value of the first bin
  int width = 1;  ///< grey values per bin; bin b holds low + b width to low + (b + 1) width - 1
  std::vector<std::uint64_t> all;      ///< voxels per bin
  std::vector<std::uint64_t> body;     ///< labelled voxels per bin; empty if no labels lie on the scan's grid
  std::uint64_t below = 0, above = 0;  ///< voxels of `all` outside the bins
};

/// Counts every voxel once. There are at most `most_bins` bins, each 1, 2 or 5 times a power of ten wide.
/// They cover all values except 1 in 100 000 voxels at either end, since a few outliers would squeeze the
/// rest.
Histogram histogram(const GreyVolume& grey, const LabelMap* labels, int most_bins = 320, int threads = 0);

}  // namespace borelli
