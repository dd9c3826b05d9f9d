// A start at which things overlap, moved until they only touch.
#pragma once

#include <string>

#include "dynamics/system/system.hpp"

namespace borelli {

/// Moves `state` to where no contact overlaps and the other constraints hold: by the least moves, measured by
/// the mass matrix (Gauss-Newton). Velocities stay. What overlapped, and how far the start was moved, in
/// words; empty: nothing did. Fails with the name of a contact that it cannot put apart.
Result<std::string> put_apart(const System& system, const Parameters& parameters, State& state);

}  // namespace borelli
