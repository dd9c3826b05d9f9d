// Which parts of a scene are independent of each other, and the lengths that are theirs: what their motion
// and residuals are measured against, so that neither a heavier nor a larger neighbour hides what goes wrong.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

/// Fills in the groups of bodies, efforts, constraints and velocities.
void find_groups(System& system);

/// Fills in velocity_scale and row_scale. A body's own length is the largest of its inertia's extent, of the
/// points that efforts and constraints touch on it, of its solids' offsets, and of its offset from its parent
/// (from the world only what lies behind its first switch: where a tree stands says nothing of its size). A
/// coordinate is measured by the largest of what it carries, a row by the largest of what it ties and the
/// distance that it keeps; where these are points, by the largest of the group, or 1 m. Solids that are
/// welded to the world do not count.
void find_lengths(System& system);

}  // namespace borelli
