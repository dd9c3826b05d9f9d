// Subtrees of one form: the limbs of a body, the bars of a rack. What is computed of each is the same, with
// other numbers, so that they may be computed side by side (articulated_side.hpp).
#pragma once

#include <array>
#include <vector>

#include "dynamics/numbers/lanes.hpp"

namespace borelli {

struct System;

/// As many subtrees as there are lanes, or fewer; no body is in two of them, and what carries them is in
/// none.
struct AlikeTrees {
  using Each = std::array<int, Quad::count>;
  int count = 0;             ///< how many there are; lanes beyond repeat the first
  std::vector<Each> bodies;  ///< of each tree one, with the same place in it; a parent before its children
  std::vector<int> parents;  ///< which of `bodies` carries them; -1: what carries the trees
};

/// Whether the parent of body b is the world, or is welded to it directly or through other bodies
/// (Welds::kept).
bool begins_at_world(const System& system, int b);

/// Those of a scene, without drives and without what is welded (Welds::kept), chosen so that the fewest
/// computations are left.
std::vector<AlikeTrees> find_alike_trees(const System& system);

}  // namespace borelli
