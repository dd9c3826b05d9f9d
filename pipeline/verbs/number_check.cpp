#include "pipeline/verbs/number_check.hpp"

#include <fmt/core.h>

#include <cmath>
#include <string>

namespace borelli {
namespace {

// CLI11 calls it with the text and shows its answer as the error; "" means valid.
CLI::Validator number_check(bool zero_is_fine, const std::string& expected, const std::string& type) {
  return {[zero_is_fine, expected](const std::string& text) -> std::string {
            double value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && std::isfinite(value) &&
                              (zero_is_fine ? value >= 0 : value > 0);
            return fine ? "" : "is " + text + ", expected " + expected;
          },
          type};
}

}  // namespace

CLI::Validator positive_number() { return number_check(false, "a positive number", "POSITIVE"); }

CLI::Validator number_not_negative() { return number_check(true, "0 or a positive number", "NOT NEGATIVE"); }

CLI::Validator number_within(double least, double most) {
  return {[least, most](const std::string& text) -> std::string {
            double value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
            return fine ? "" : fmt::format("is {}, expected a number from {:g} to {:g}", text, least, most);
          },
          fmt::format("{:g} TO {:g}", least, most)};
}

}  // namespace borelli
