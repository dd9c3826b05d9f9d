// Where each coordinate stands in the engine's arrays, and which depend on which.
#pragma once

#include <vector>

#include "dynamics/system.hpp"

namespace borelli {

/// Puts the driven coordinates behind the free ones, and lists supports, ancestors and the mass matrix's
/// pattern. `chains`: per body, the steps of its chain from the world; `previous`: per step, the last free
/// step before it on its chain, -1: none.
void lay_out_coordinates(System& system, const std::vector<std::vector<int>>& chains,
                         const std::vector<int>& previous);

}  // namespace borelli
