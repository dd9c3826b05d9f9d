// Stated deviations of landmarks against their errors (tests/suite/landmark_trials.hpp): bodies of 1.25 to
// 2.0 m on slices of 3 to 8 mm. The program `landmark_trials` prints a table for more bodies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "tests/suite/landmark_trials.hpp"

namespace borelli {
namespace {

// Two standard deviations cover 95 % of normal errors; the count of n coordinates may be three binomial
// deviations lower.
void expect_honest(int within, int all, const std::string& what) {
  const double share = static_cast<double>(within) / all;
  EXPECT_GT(share, 0.95 - 3 * std::sqrt(0.95 * 0.05 / all)) << what << ": " << within << " of " << all;
}

TEST(LandmarkDeviations, CoverAboutNineteenOfTwentyErrors) {
  std::map<std::string, std::pair<int, int>> count;  // by landmark: within, all
  int within = 0, all = 0;
  for (const auto& [seed, slice] : {std::pair{1, 8.0}, {5, 8.0}, {6, 3.0}, {9, 5.0}}) {
    const auto trial = suite::try_landmarks(static_cast<std::uint64_t>(seed), slice);
    EXPECT_TRUE(trial.lost.empty()) << trial.lost.front();
    if (slice > 5) {
      EXPECT_TRUE(std::any_of(trial.warnings.begin(), trial.warnings.end(), [](const std::string& warning) {
        return warning.starts_with("voxels of 8.0 mm are large");
      }));
    }
    for (const auto& found : trial.landmarks) {
      auto& [in, of] = count[suite::stem_of(found.name)];
      for (int c = 0; c < 3; ++c) {
        const bool holds = std::abs(found.error[c]) <= 2 * found.deviation;
        in += holds, ++of, within += holds, ++all;
      }
    }
  }
  expect_honest(within, all, "all");
  for (const auto& [stem, in_of] : count) expect_honest(in_of.first, in_of.second, stem);
}

}  // namespace
}  // namespace borelli
