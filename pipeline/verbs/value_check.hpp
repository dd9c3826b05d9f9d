// Validators for values on the command line, with readable errors.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace borelli {

/// Finite, of any sign.
CLI::Validator finite_number();

/// Finite and above 0.
CLI::Validator positive_number();

/// Finite and 0 or more.
CLI::Validator number_not_negative();

/// From `least` to `most`; unlike CLI::Range it refuses text that is not a number.
CLI::Validator number_within(double least, double most);

/// A whole number from `least` to `most`.
CLI::Validator whole_number_within(long least, long most);

/// One of these words.
CLI::Validator one_of(const std::vector<std::string>& words);

}  // namespace borelli
