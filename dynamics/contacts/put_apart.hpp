// Moves an overlapping start until shapes only touch.
#pragma once

#include <string>

#include "dynamics/system/system.hpp"

namespace borelli {

/// Moves the positions of `state` until no contact overlaps and the other constraints hold, by least moves in
/// the norm of the mass matrix (Gauss-Newton). Velocities stay. Returns a sentence that names what overlapped
/// and how far the start moved; empty: nothing overlapped. Fails with the name of a contact that it cannot
/// separate.
Result<std::string> put_apart(const System& system, const Parameters& parameters, State& state);

}  // namespace borelli
