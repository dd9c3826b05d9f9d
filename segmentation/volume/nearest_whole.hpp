// The nearest whole number, where millions of places are asked for the voxel that holds them.
#pragma once

#include <cstdint>

namespace borelli {

/// As std::lround (halves go away from zero), within the range of the answer, but compiled in place: what is
/// cut off is exact.
inline std::int64_t nearest_whole(double x) {
  const auto towards_zero = static_cast<std::int64_t>(x);
  const double rest = x - static_cast<double>(towards_zero);
  return towards_zero + (rest >= 0.5) - (rest <= -0.5);
}

}  // namespace borelli
