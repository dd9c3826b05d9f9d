// How often the exact value of each table entry lies within two of its standard deviations: deviations_bench
// [mr] [trials] [finest mm] [coarsest]; `mr` draws MR scans. Not a timing, but a longer run of
// tests/pipeline/deviations_test.cpp.
#include <fmt/core.h>

#include <cstdlib>
#include <string_view>

#include "segmentation/volume/held_memory.hpp"
#include "tests/pipeline/deviation_trials.hpp"
#include "tests/pipeline/mr_trials.hpp"

int main(int argc, char** argv) {
  borelli::hold_freed_memory();
  using namespace borelli;
  const bool mr = argc > 1 && std::string_view(argv[1]) == "mr";
  if (mr) --argc, ++argv;
  const int trials = argc > 1 ? std::atoi(argv[1]) : 100;
  const double finest = argc > 2 ? std::atof(argv[2]) : 3, coarsest = argc > 3 ? std::atof(argv[3]) : 6;
  std::map<std::string, test::TrialCount> counts, parts;
  for (int n = 0; n < trials; ++n) {
    if (mr) {
      test::try_mr(3000 + static_cast<std::uint32_t>(n), finest, coarsest, counts, parts);
      continue;
    }
    PhantomOptions options;
    options.sex = n % 2 ? Sex::female : Sex::male;
    test::try_deviations(build_phantom(options).value(), 1000 + static_cast<std::uint32_t>(n), finest,
                         coarsest, counts);
  }
  test::TrialCount all;
  for (const auto& [entry, count] : counts) {
    all.cases += count.cases, all.within += count.within;
    fmt::print("{:<24} {:>7} cases {:>6.1f} % within two deviations, {:.2f} rms\n", entry, count.cases,
               100 * count.share(), std::sqrt(count.squares / count.cases));
  }
  for (const auto& [part, count] : parts)
    fmt::print("mass of {:<16} {:>7} cases {:>6.1f} % within two deviations, {:.2f} rms\n", part, count.cases,
               100 * count.share(), std::sqrt(count.squares / count.cases));
  fmt::print("all {} cases {:.1f} %\n", all.cases, 100 * all.share());
}
