// Where each coordinate stands in the engine's arrays, and how many each body depends on.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

/// Puts the driven coordinates behind the free ones, and counts the bodies' supports. (Which coordinates they
/// are is laid out later: Branches.)
void lay_out_coordinates(System& system);

}  // namespace borelli
