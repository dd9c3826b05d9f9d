#include "pipeline/verbs/value_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "error/nearest_name.hpp"

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

CLI::Validator positive_number() { return number_check(false, "a positive number", "above 0"); }

CLI::Validator number_not_negative() { return number_check(true, "0 or a positive number", "0 or more"); }

CLI::Validator finite_number() {
  return {[](const std::string& text) -> std::string {
            double value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
            return fine ? "" : "is " + text + ", expected a number";
          },
          ""};
}

CLI::Validator number_within(double least, double most) {
  return {[least, most](const std::string& text) -> std::string {
            double value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
            return fine ? "" : fmt::format("is {}, expected a number from {:g} to {:g}", text, least, most);
          },
          fmt::format("{:g} to {:g}", least, most)};
}

CLI::Validator whole_number_within(long least, long most) {
  return {[least, most](const std::string& text) -> std::string {
            long value = 0;
            const bool fine = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
            return fine ? "" : fmt::format("is {}, expected a whole number from {} to {}", text, least, most);
          },
          fmt::format("{} to {}", least, most)};
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  return {[words](const std::string& text) -> std::string {
            if (std::ranges::find(words, text) != words.end()) return "";
            const auto meant = nearest_name(text, words);
            return fmt::format("is '{}', expected one of {}{}", text, fmt::join(words, ", "),
                               meant ? fmt::format("; did you mean {}?", *meant) : "");
          },
          fmt::format("{{{}}}", fmt::join(words, ","))};
}

}  // namespace borelli
