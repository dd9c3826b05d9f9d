// The layout of coordinates in the arrays of the engine, and the size of the support of each body.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

/// Puts the driven coordinates behind the free ones, and counts the support of each body. (Branches lists the
/// supports later.)
void lay_out_coordinates(System& system);

}  // namespace borelli
