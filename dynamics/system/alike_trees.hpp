// Subtrees of equal structure, such as the limbs of a body. Each needs the same computation with other
// numbers, so they can be evaluated side by side (articulated_side.hpp).
#pragma once

#include <array>
#include <vector>

#include "dynamics/numbers/lanes.hpp"

namespace borelli {

struct System;

/// Up to Quad::count subtrees of equal structure. They share no body, and the body that carries them is in
/// none.
struct AlikeTrees {
  using Each = std::array<int, Quad::count>;
  int count = 0;             ///< number of subtrees; unused lanes repeat the first
  std::vector<Each> bodies;  ///< corresponding bodies, one per lane; parents before their children
  std::vector<int> parents;  ///< index in `bodies` of their parents; -1: the body that carries the trees
};

/// Whether the parent of body b is the world, directly or through welded bodies (Welds::kept).
bool begins_at_world(const System& system, int b);

/// Finds the alike trees of a scene that minimise the cost of computation. Subtrees with driven coordinates
/// or welded bodies (Welds::kept) are left out.
std::vector<AlikeTrees> find_alike_trees(const System& system);

}  // namespace borelli
