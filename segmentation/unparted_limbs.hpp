// Parts of limbs that hold what hangs on them too, since no joint was found between.
#pragma once

#include "segmentation/part_planes.hpp"
#include "segmentation/segment.hpp"

namespace borelli {

/// A limb's part that ends within the scan, without a plane at its far joint, holds what hangs on it.
void tell_what_is_not_parted(const PartPlanes& planes, Segmentation& out);

/// A limb's part that the scan cuts, without its far joint, is in doubt where it reaches beyond the other
/// side's length (or, of a thigh whose hip is not told either, below the other side's knee).
void doubt_unparted_limbs(Segmentation& out);

}  // namespace borelli
