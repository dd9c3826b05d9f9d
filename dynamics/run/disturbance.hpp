// Disturbs a state slightly, to see how differences grow.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

/// `state` with each velocity changed by `part` of its scale (System::velocity_scale), with alternating
/// signs, projected on what constraints and closed contacts allow. Positions are unchanged. Deterministic.
State disturbed(const System& system, const State& state, double part);

}  // namespace borelli
