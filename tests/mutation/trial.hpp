// Reads mutations in forked workers, so that a crash does not end the program. Each worker reads many.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/mutation/reader.hpp"

namespace borelli::mutation {

struct TrialLimits {
  double seconds = 10;  ///< processor time of one reading; the clock may take three times as long
  std::uint64_t bytes = std::uint64_t{2} << 30;  ///< memory beyond what this program has mapped
};

struct Failure {
  std::uint64_t number = 0;
  std::string what;
};

struct Trials {
  std::uint64_t runs = 0, refused = 0;
  std::string last_refusal;  ///< the reader's words
  std::vector<Failure> failures;
};

/// Reads case_of(n) for n in [first, last) with files in `folder`, until `seconds` have passed.
Trials run_trials(const Reader& reader, const std::function<TestCase(std::uint64_t)>& case_of,
                  std::uint64_t first, std::uint64_t last, double seconds, const TrialLimits& limits,
                  const std::filesystem::path& folder);

}  // namespace borelli::mutation
