// Sums over boxes of a volume in constant time (summed-area table; Crow 1984, SIGGRAPH 18:207).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A box of voxels, both ends included.
struct VoxelBox {
  std::array<std::int64_t, 3> low, high;
};

/// The table holds sums modulo 2^32: a box's sum is correct if it fits a signed 32-bit integer.
class BoxSums {
 public:
  /// `value(offset)` gives the voxel's integer value.
  template <class Value>
  BoxSums(const Grid& grid, const Value& value)
      : size_(grid.size), row_(grid.size[0] + 1), slice_(row_ * (grid.size[1] + 1)) {
    table_.assign(static_cast<std::size_t>(slice_ * (grid.size[2] + 1)), 0);
    for (std::int64_t k = 0; k < size_[2]; ++k)
      for (std::int64_t j = 0; j < size_[1]; ++j) {
        std::uint32_t along = 0;
        for (std::int64_t i = 0; i < size_[0]; ++i) {
          along += static_cast<std::uint32_t>(static_cast<std::int32_t>(value(grid.offset(i, j, k))));
          at(i + 1, j + 1, k + 1) = along + at(i + 1, j, k + 1) + at(i + 1, j + 1, k) - at(i + 1, j, k);
        }
      }
  }

  /// Sum over the part of the box that lies in the grid.
  std::int32_t sum(const VoxelBox& box) const {
    std::array<std::int64_t, 3> low, high;
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::clamp<std::int64_t>(box.low[c], 0, size_[c]);
      high[c] = std::clamp<std::int64_t>(box.high[c] + 1, low[c], size_[c]);
    }
    const auto plane = [&](std::int64_t k) {
      return get(high[0], high[1], k) - get(low[0], high[1], k) - get(high[0], low[1], k) +
             get(low[0], low[1], k);
    };
    return static_cast<std::int32_t>(plane(high[2]) - plane(low[2]));
  }

 private:
  std::uint32_t& at(std::int64_t i, std::int64_t j, std::int64_t k) {
    return table_[static_cast<std::size_t>(k * slice_ + j * row_ + i)];
  }
  std::uint32_t get(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return table_[static_cast<std::size_t>(k * slice_ + j * row_ + i)];
  }

  std::array<std::int64_t, 3> size_;
  std::int64_t row_, slice_;
  std::vector<std::uint32_t> table_;
};

}  // namespace borelli
