#include "segmentation/grid/noise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace borelli {

double estimate_noise(const GreyVolume& volume, const LabelMap& labels) {
  std::vector<int> seen;
  const Grid& g = labels.grid;
  const auto rows = static_cast<std::int64_t>(g.size[1] * g.size[2]);
  const std::int64_t skip = std::max<std::int64_t>(1, rows / 20000);
  for (std::int64_t row = 0; row < rows; row += skip) {
    const auto start = static_cast<std::size_t>(row * g.size[0]);
    for (std::int64_t i = 1; i + 1 < g.size[0]; ++i) {
      const auto o = start + static_cast<std::size_t>(i);
      if (!labels.voxels[o - 1] || !labels.voxels[o] || !labels.voxels[o + 1]) continue;
      seen.push_back(std::abs(volume.voxels[o - 1] - 2 * volume.voxels[o] + volume.voxels[o + 1]));
    }
  }
  // differences are large where tissues meet: excludes those beyond three deviations until none is left
  double noise = 0;
  for (int round = 0; round < 10; ++round) {
    if (seen.size() < 100) return 0;
    const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
    std::nth_element(seen.begin(), middle, seen.end());
    const double one = *middle / 0.6745;
    noise = one / std::sqrt(6.0);
    if (std::erase_if(seen, [&](int difference) { return difference > 3 * one; }) == 0) break;
  }
  return noise;
}

}  // namespace borelli
