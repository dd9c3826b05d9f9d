// A state a little off another, to see what becomes of the difference.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

/// `state` with every velocity off by up to `part` of its scale (System::velocity_scale), now up, now down,
/// but for what constraints and closed contacts forbid. Positions stay. The same state gives the same.
State disturbed(const System& system, const State& state, double part);

}  // namespace borelli
