#include "segmentation/files/value_range.hpp"

#include <cmath>
#include <limits>
#include <mutex>

#include "threads/slabs.hpp"

namespace borelli {

bool are_whole(const StoredVoxels& voxels, double slope, double intercept) {
  const auto small = [](double x) { return x == std::floor(x) && std::abs(x) <= 16384; };
  return scalar_bytes(voxels.scalar) <= 2 && small(slope) && small(intercept);
}

namespace {

// As value_range, if are_whole: compares the stored numbers, whose order the slope keeps or reverses.
template <class T>
ValueRange whole_range(const StoredVoxels& voxels, double slope, double intercept, std::size_t first,
                       std::size_t last) {
  const auto* const stored = reinterpret_cast<const T*>(voxels.bytes());
  const auto value = [&](T x) {
    return static_cast<double>(static_cast<std::int32_t>(slope) * x + static_cast<std::int32_t>(intercept));
  };
  ValueRange all;
  constexpr std::size_t together = 1 << 15;  // as in each_block; its counts fit into 16 bits
  for (std::size_t from = first; from < last; from += together) {
    const std::size_t to = std::min(from + together, last);
    T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::min();
    for (std::size_t n = from; n < to; ++n) low = std::min(low, stored[n]), high = std::max(high, stored[n]);
    const T least = slope < 0 ? high : low, greatest = slope < 0 ? low : high;
    std::uint16_t equal = 0;
    for (std::size_t n = from; n < to; ++n) equal += stored[n] == least;
    all += {.least = value(least),
            .greatest = value(greatest),
            .count = to - from,
            .at_least = slope == 0 ? to - from : equal};
  }
  return all;
}

}  // namespace

ValueRange& ValueRange::operator+=(const ValueRange& other) {
  const bool none = not_finite == count;
  if (other.not_finite < other.count) {
    if (none || other.least < least)
      at_least = other.at_least;
    else if (other.least == least)
      at_least += other.at_least;
    least = none ? other.least : std::min(least, other.least);
    greatest = none ? other.greatest : std::max(greatest, other.greatest);
  }
  count += other.count, not_finite += other.not_finite, fractional += other.fractional;
  return *this;
}

ValueRange value_range(const StoredVoxels& voxels, double slope, double intercept, std::size_t first,
                       std::size_t last) {
  if (are_whole(voxels, slope, intercept))
    return with_scalar(voxels.scalar, [&]<class T>(T) {
      if constexpr (std::is_integral_v<T> && sizeof(T) <= 2)
        return whole_range<T>(voxels, slope, intercept, first, last);
      return ValueRange{};  // (not reached: are_whole is false for other types)
    });
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  ValueRange r;
  const auto count = [&](const auto& read, std::size_t from, std::size_t to) {
    for (std::size_t n = from; n < to; ++n) {
      const double v = read(n);
      if (!std::isfinite(v)) {
        ++r.not_finite;
        continue;
      }
      r.at_least = v < least ? 1 : r.at_least + (v == least);
      least = std::min(least, v), greatest = std::max(greatest, v);
      r.fractional += v != std::floor(v);
    }
  };
  each_block(voxels, first, last, slope, intercept, count);
  r.count = last - first;
  if (r.not_finite < r.count) r.least = least, r.greatest = greatest;
  return r;
}

ValueRange value_range(const StoredVoxels& voxels, double slope, double intercept) {
  ValueRange all;
  std::mutex mutex;
  in_slabs(static_cast<std::int64_t>(voxels.count), 0, [&](std::int64_t first, std::int64_t last) {
    const ValueRange own = value_range(voxels, slope, intercept, static_cast<std::size_t>(first),
                                       static_cast<std::size_t>(last));
    const std::lock_guard lock(mutex);
    all += own;
  });
  return all;
}

}  // namespace borelli
