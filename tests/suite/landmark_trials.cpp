// landmark_trials: errors of landmarks against their stated deviations, as a table by kind of landmark and
// slice thickness.
//   landmark_trials [--each] [--seeds FIRST LAST] [--slices MM[,MM...]]
// Each trial draws a body of 1.25 to 2.0 m, slight to stout, of either sex, with its own pose and bones, on
// slices of 2, 3, 5 or 8 mm. --each: every landmark of every trial on a line of its own, with its error.
#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "segmentation/volume/held_memory.hpp"
#include "tests/suite/landmark_trials.hpp"

int main(int count, char** words) {
  borelli::hold_freed_memory();
  using namespace borelli;
  bool each = false;
  std::uint64_t first = 1, last = 12;
  std::vector<double> slices{2, 3, 5, 8};
  for (int n = 1; n < count; ++n) {
    if (!std::strcmp(words[n], "--each")) {
      each = true;
    } else if (!std::strcmp(words[n], "--seeds") && n + 2 < count) {
      first = std::strtoull(words[n + 1], nullptr, 10), last = std::strtoull(words[n + 2], nullptr, 10);
      n += 2;
    } else if (!std::strcmp(words[n], "--slices") && n + 1 < count) {
      slices.clear();
      std::istringstream list(words[++n]);
      for (std::string one; std::getline(list, one, ',');)
        slices.push_back(std::strtod(one.c_str(), nullptr));
    } else {
      fmt::print(stderr, "landmark_trials [--each] [--seeds FIRST LAST] [--slices MM[,MM...]]\n");
      return 2;
    }
  }
  struct Sum {
    int coordinates = 0, within = 0;
    double squares = 0, stated = 0, in_deviations = 0;
  };
  std::map<std::string, std::map<double, Sum>> sums;
  for (std::uint64_t seed = first; seed <= last; ++seed)
    for (const double slice : slices) {
      const auto trial = suite::try_landmarks(seed, slice);
      for (const auto& found : trial.landmarks) {
        if (each)
          fmt::print("{} {} {:.2f} {} {:.2f} {:.2f} {:.2f} {:.2f} {}\n", seed, slice, trial.stature_m,
                     found.name, found.error[0], found.error[1], found.error[2], found.deviation,
                     found.source);
        Sum& sum = sums[suite::stem_of(found.name)][slice];
        for (int c = 0; c < 3; ++c) {
          const double share = found.error[c] / found.deviation;
          ++sum.coordinates, sum.within += std::abs(share) <= 2;
          sum.squares += found.error[c] * found.error[c], sum.in_deviations += share * share;
          sum.stated += found.deviation;
        }
      }
      for (const std::string& warning : trial.warnings)
        if (each) fmt::print("{} {} {:.2f} warning {}\n", seed, slice, trial.stature_m, warning);
      std::fflush(stdout);
    }
  if (each) return 0;
  fmt::print(
      "| landmark | slices, mm | coordinates | within two deviations, % | rms error, mm | stated, mm | rms "
      "in deviations |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const auto& [stem, by_slice] : sums)
    for (const auto& [slice, sum] : by_slice)
      fmt::print("| {} | {:g} | {} | {:.0f} | {:.1f} | {:.1f} | {:.2f} |\n", stem, slice, sum.coordinates,
                 100.0 * sum.within / sum.coordinates, std::sqrt(sum.squares / sum.coordinates),
                 sum.stated / sum.coordinates, std::sqrt(sum.in_deviations / sum.coordinates));
  return 0;
}
