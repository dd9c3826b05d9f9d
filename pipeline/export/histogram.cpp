#include "pipeline/export/histogram.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <mutex>
#include <numeric>

#include "threads/slabs.hpp"

namespace borelli {

namespace {

constexpr int least = std::numeric_limits<std::int16_t>::min();
constexpr std::size_t values = 1 << 16;

/// Voxels of each grey value from `least` on: outside the body, and inside.
using Counts = std::array<std::vector<std::uint64_t>, 2>;

Counts count(const GreyVolume& grey, const LabelMap* labels, std::size_t first, std::size_t last) {
  Counts counts{std::vector<std::uint64_t>(values), std::vector<std::uint64_t>(values)};
  for (std::size_t at = first; at < last; ++at)
    ++counts[labels && labels->voxels[at] != 0][static_cast<std::size_t>(grey.voxels[at] - least)];
  return counts;
}

/// The smallest round width that fits `span` values into at most `most` bins.
int round_width(int span, int most) {
  for (int power = 1;; power *= 10)
    for (const int digit : {1, 2, 5})
      if (span <= most * digit * power) return digit * power;
}

}  // namespace

Histogram histogram(const GreyVolume& grey, const LabelMap* labels, int most_bins, int threads) {
  if (labels && !(labels->grid == grey.grid)) labels = nullptr;
  const std::size_t n = grey.voxels.size();
  std::vector<std::uint64_t> all(values), body(values);
  std::mutex mutex;
  in_slabs(static_cast<std::int64_t>(n), threads, [&](std::int64_t first, std::int64_t last) {
    const Counts counts =
        count(grey, labels, static_cast<std::size_t>(first), static_cast<std::size_t>(last));
    const std::lock_guard lock(mutex);
    for (std::size_t v = 0; v < values; ++v) {
      all[v] += counts[0][v] + counts[1][v];
      body[v] += counts[1][v];
    }
  });

  Histogram made;
  if (n == 0) return made;
  const std::uint64_t stray = n / 100'000;
  std::size_t first = 0, last = values - 1;
  for (std::uint64_t passed = all[first]; passed <= stray; passed += all[++first]) {
  }
  for (std::uint64_t passed = all[last]; passed <= stray; passed += all[--last]) {
  }
  // one bin is reserved for rounding the start
  made.width = round_width(static_cast<int>(last - first + 1), most_bins - 1);
  const int from = least + static_cast<int>(first), to = least + static_cast<int>(last);
  made.low = from - ((from % made.width) + made.width) % made.width;
  const auto bins = static_cast<std::size_t>((to - made.low) / made.width + 1);
  made.all.assign(bins, 0);
  if (labels) made.body.assign(bins, 0);
  for (std::size_t v = 0; v < values; ++v) {
    const int over = least + static_cast<int>(v) - made.low;
    if (over < 0) {
      made.below += all[v];
    } else if (const auto bin = static_cast<std::size_t>(over / made.width); bin >= bins) {
      made.above += all[v];
    } else {
      made.all[bin] += all[v];
      if (labels) made.body[bin] += body[v];
    }
  }
  return made;
}

}  // namespace borelli
