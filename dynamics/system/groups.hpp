// Independent groups of a scene and their characteristic lengths. Motion and residuals are compared with
// these lengths, so that a heavier or larger neighbour cannot hide an error.
#pragma once

#include "dynamics/system/system.hpp"

namespace borelli {

/// Fills in the groups of bodies, efforts, constraints and velocities.
void find_groups(System& system);

/// Fills in velocity_scale and row_scale, m (1 for angles).
/// - The length of a body is the largest of the extent of its inertia, the points of efforts and constraints
///   on it, the offsets of its solids, and its offset from its parent. From the world only offsets behind its
///   first switch count: where a tree stands says nothing of its size.
/// - The scale of a coordinate is the largest length of the bodies it carries.
/// - The scale of a row is the largest length of the bodies it ties, or the distance that it keeps.
/// - Where these lengths are zero, the largest of the group counts, or 1 m. Solids welded to the world do not
///   count.
void find_lengths(System& system);

}  // namespace borelli
