// Whether a run can be made as it is asked for.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

/// Beyond this no scene of solids means anything: a run whose coordinates or velocities come there has
/// diverged.
inline constexpr double largest_number = 1e12;

// Beyond these a run is a slip of the pen: a billion steps of the smallest scene take an hour, ten million
// rows of it some gigabytes.
inline constexpr double most_steps = 1e9, most_rows = 1e7;

/// Settings that make no sense for a run from time `start` (s), by name.
Result<void> check_settings(const SimulationSettings& settings, double start);

/// Counts that are known beforehand: rows of output, and steps where they are fixed or held by a sine.
Result<void> check_counts(const System& system, double start, const SimulationSettings& settings,
                          bool adaptive);

}  // namespace borelli
