// Finds out whether efforts, drives or constraints of a scene change with time. If they do, an equilibrium
// holds for an instant only, and small deviations have no modes.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// The functions of time of a scene, and later times at which a change by them shows.
struct ChangeInTime {
  std::string name;           ///< of the fastest function, e.g. "effort 'push'"; empty: no function of time
  std::vector<double> times;  ///< s

  /// "the scene changes with time (fastest: effort 'push')"
  std::string words() const { return "the scene changes with time (fastest: " + name + ")"; }
};

/// The times are fractions and multiples of the fastest function's period after t, and the next knots of
/// tables.
ChangeInTime change_in_time(const System& system, double t);

}  // namespace borelli
