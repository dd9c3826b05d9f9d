// Validators for numbers on the command line, with readable errors.
#pragma once

#include <CLI/CLI.hpp>

namespace borelli {

/// Finite and above 0.
CLI::Validator positive_number();

/// Finite and 0 or more.
CLI::Validator number_not_negative();

/// From `least` to `most`; unlike CLI::Range it refuses text that is not a number.
CLI::Validator number_within(double least, double most);

}  // namespace borelli
