// Fast rounding to the nearest integer, for finding the voxels of millions of positions.
#pragma once

#include <cstdint>

namespace borelli {

/// As std::lround (halves round away from zero), but inlined. `x` must be within the range of std::int64_t.
/// The truncated part is exact, so rounding is too.
inline std::int64_t nearest_whole(double x) {
  const auto towards_zero = static_cast<std::int64_t>(x);
  const double rest = x - static_cast<double>(towards_zero);
  return towards_zero + (rest >= 0.5) - (rest <= -0.5);
}

}  // namespace borelli
