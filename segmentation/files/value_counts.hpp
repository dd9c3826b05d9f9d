// How many voxels of a volume have each value.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

class ValueCounts {
 public:
  explicit ValueCounts(const GreyVolume& volume);

  std::int64_t at(int value) const { return between(value, value); }
  /// Voxels with values from `low` to `high`; bounds beyond int16 are cut.
  std::int64_t between(int low, int high) const;
  /// All voxels but those with padding_hu.
  std::int64_t seen() const { return between(INT16_MIN, INT16_MAX) - at(padding_hu); }
  std::int16_t least() const { return least_; }
  std::int16_t greatest() const { return greatest_; }

 private:
  std::vector<std::int64_t> below_;  // voxels below each int16, from the least on; one past the end: all
  std::int16_t least_ = 0, greatest_ = 0;
};

}  // namespace borelli
