#include "segmentation/files/value_counts.hpp"

#include <algorithm>
#include <mutex>

#include "threads/slabs.hpp"

namespace borelli {

ValueCounts::ValueCounts(const GreyVolume& volume) : below_((1 << 16) + 1) {
  std::mutex mutex;
  in_slabs(std::ssize(volume.voxels), 0, [&](std::int64_t first, std::int64_t last) {
    std::vector<std::int64_t> own(1 << 16);
    for (std::int64_t n = first; n < last; ++n)
      ++own[static_cast<std::size_t>(volume.voxels[static_cast<std::size_t>(n)] - INT16_MIN)];
    const std::lock_guard lock(mutex);
    for (std::size_t n = 0; n < own.size(); ++n) below_[n + 1] += own[n];
  });
  for (std::size_t n = 1; n < below_.size(); ++n) below_[n] += below_[n - 1];
  const auto value = [&](auto place) {
    return static_cast<std::int16_t>(place - below_.begin() + INT16_MIN - 1);
  };
  least_ = value(std::ranges::upper_bound(below_, 0));
  greatest_ = value(std::ranges::lower_bound(below_, below_.back()));
}

std::int64_t ValueCounts::between(int low, int high) const {
  low = std::max<int>(low, INT16_MIN), high = std::min<int>(high, INT16_MAX);
  if (low > high) return 0;
  return below_[static_cast<std::size_t>(high - INT16_MIN + 1)] -
         below_[static_cast<std::size_t>(low - INT16_MIN)];
}

}  // namespace borelli
