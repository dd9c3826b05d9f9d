// Whether what moves a scene changes with time: an equilibrium then holds for an instant only, and small
// deviations have no modes.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

/// What changes with time in the scene, and later times (s) at which the change shows.
struct ChangeInTime {
  std::string name;  ///< of the fastest function, e.g. "effort 'push'"; empty: nothing changes
  std::vector<double> times;
};

/// The times are fractions and multiples of the fastest function's period after t, and the next knots of
/// tables.
ChangeInTime change_in_time(const System& system, double t);

}  // namespace borelli
