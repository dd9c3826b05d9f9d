// The range of a volume file's values, and loops over them that vectorise.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "segmentation/files/image_file.hpp"

namespace borelli {

/// Range and kinds of a volume's values, after slope and intercept.
struct ValueRange {
  double least = 0, greatest = 0;  ///< of the finite values; 0 if there are none
  std::size_t count = 0;
  std::size_t not_finite = 0;  ///< NaN or infinite
  std::size_t fractional = 0;  ///< finite and not a whole number
  std::size_t at_least = 0;    ///< equal to the least

  ValueRange& operator+=(const ValueRange& other);  ///< joins the ranges of two sets of voxels
};
ValueRange value_range(const StoredVoxels& voxels, double slope, double intercept);
/// The same for voxels [first, last), on the calling thread; the others need not be loaded yet.
ValueRange value_range(const StoredVoxels& voxels, double slope, double intercept, std::size_t first,
                       std::size_t last);

/// Whether all values are whole and fit int32: voxels of at most 16 bits, scaled by whole numbers. Loops over
/// such values vectorise, loops over doubles do not.
bool are_whole(const StoredVoxels& voxels, double slope, double intercept);

/// Calls f(read, first, last) for blocks of voxels in memory order; read(n) is the n-th voxel's value, int32 if
/// are_whole, else double.
template <class F>
void each_block(const StoredVoxels& voxels, std::size_t first, std::size_t last, double slope,
                double intercept, F&& f) {
  constexpr std::size_t together = 1 << 15;  // a block fits into the L1 or L2 cache, its counts into 32 bits
  with_scalar(voxels.scalar, [&]<class T>(T) {
    const auto go = [&]<class Number>(Number times, Number plus) {
      const std::byte* const bytes = voxels.bytes();
      const auto read = [=](std::size_t n) {
        T stored;
        std::memcpy(&stored, bytes + n * sizeof(T), sizeof stored);
        return times * static_cast<Number>(stored) + plus;
      };
      for (std::size_t n = first; n < last; n += together) f(read, n, std::min(n + together, last));
    };
    if constexpr (std::is_integral_v<T> && sizeof(T) <= 2)
      if (are_whole(voxels, slope, intercept)) {
        go(static_cast<std::int32_t>(slope), static_cast<std::int32_t>(intercept));
        return;
      }
    go(slope, intercept);
  });
}

}  // namespace borelli
