#include "segmentation/files/display_window.hpp"

#include <fmt/core.h>

namespace borelli {
DisplayWindow display_window(const ValueCounts& counts) {
  constexpr int beside = 20;         // values next to an end; a clipped end stands out among them
  constexpr double piled = 10;       // times the mean voxel count of the other values
  constexpr int fewest = 64;         // different values in an image with noise or partial volumes
  constexpr int airless = -500;      // HU: a least value above this shows no air
  constexpr int densest_cut = 1500;  // HU: cortical bone exceeds this
  constexpr double much = 0.1, some = 0.002;
  DisplayWindow window;
  const auto count = [&](int value) { return static_cast<double>(counts.at(value)); };
  int least = padding_hu + 1, greatest = INT16_MAX, different = 0;
  while (least < greatest && count(least) == 0) ++least;
  while (greatest > least && count(greatest) == 0) --greatest;
  double seen = 0;
  for (int value = least; value <= greatest; ++value) seen += count(value), different += count(value) > 0;
  if (seen == 0 || different < fewest || greatest - least < 2 * beside) return window;
  double above = 0, below = 0;
  for (int n = 1; n <= beside; ++n) above += count(least + n) / beside, below += count(greatest - n) / beside;
  window.least = static_cast<std::int16_t>(least), window.greatest = static_cast<std::int16_t>(greatest);
  window.at_least = count(least) / seen, window.at_greatest = count(greatest) / seen;
  window.low_cut = least > airless && window.at_least > much && count(least) > piled * above;
  window.high_cut = greatest < densest_cut && window.at_greatest > some && count(greatest) > piled * below;
  return window;
}

std::string advice_on(const DisplayWindow& window) {
  const bool picture = window.least == 0 && window.greatest <= 255;
  return fmt::format(
      "is not a volume of CT numbers: {:.3g} % of its voxels have the least value, {}; {}; {}",
      100 * window.at_least, window.least,
      picture
          ? "it is an 8-bit picture (0 to 255) through a display window"
          : fmt::format("lower values were cut off (by a display window{})",
                        window.high_cut ? fmt::format(" of {} to {}", window.least, window.greatest) : ""),
      "rescaling cannot restore the densities of air and fat; export the scan itself (DICOM, or NIfTI with "
      "-1024 to 3071)");
}

}  // namespace borelli
