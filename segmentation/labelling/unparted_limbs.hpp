// Parts of limbs that hold what hangs on them too, since no joint was found between.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {

/// Names the stumps: a part on which hangs one that is told to be absent is cut, and what is absent has the
/// note `absent_as_told`.
void tell_stumps(Segmentation& out);

/// A limb's part that ends within the scan, without a plane at its far joint, holds what hangs on it.
void tell_what_is_not_parted(const PartPlanes& planes, Segmentation& out);

/// A limb's part that the scan cuts, without its far joint, is in doubt where it reaches beyond the other
/// side's length (or, of a thigh whose hip is not told either, below the other side's knee; of arms that both
/// lack their elbow, beyond an adult's of that size).
void doubt_unparted_limbs(Segmentation& out);

/// Of a raised arm that the scan's side cuts before its wrist the hand may lie on the head, and counts as
/// its.
void doubt_head_under_arms(const Anatomy& anatomy, const Limbs& limbs, Segmentation& out);

}  // namespace borelli
