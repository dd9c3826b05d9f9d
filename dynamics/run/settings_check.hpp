// Checks whether a run can be made with its settings.
#pragma once

#include <string>

#include "dynamics/system/system.hpp"

namespace borelli {

/// A coordinate or velocity beyond this has diverged: no scene of solids has such values.
inline constexpr double largest_number = 1e12;

// Larger counts are taken for input errors: 1e9 steps of the smallest scene take an hour, 1e7 rows several
// gigabytes.
inline constexpr double most_steps = 1e9, most_rows = 1e7;

/// Fails if a setting is invalid for a run from time `start` (s); the message names it.
Result<void> check_settings(const SimulationSettings& settings, double start);

/// Fails if counts known in advance exceed most_steps or most_rows: output rows, and steps if they are fixed
/// or limited by a sine.
Result<void> check_counts(const System& system, double start, const SimulationSettings& settings,
                          bool adaptive);

/// Fails if a method that does not resolve contacts within its steps meets contacts that need it; the message
/// names the first.
Result<void> check_time_stepping(const System& system, const std::string& method, bool handles_contacts);

}  // namespace borelli
