// The mask of the person in a scan: without table, clothes and surrounding air, but with lungs and gut.
#pragma once

#include "segmentation/grid/morphology.hpp"
#include "segmentation/grid/work_grid.hpp"

namespace borelli {

/// Mask on the work grid, 1 inside the body. Starts from all voxels denser than the skin's edge, then:
/// - removes wide thin sheets (table shells, blankets) by shape; small thin parts (ears, fingers, toes) stay;
/// - keeps a small piece close to the body that contains bone within flesh (a thumb separated from the palm
///   by a crevice), and joins it by a row of voxels;
/// - fills hollows (lungs, airways, gut) that reach the outside air only through narrow passages or not at
///   all, also where the scan's end opens them; crevices between skin and skin stay open.
///
/// Several pieces remain if the scan's edge cuts limbs off.
Mask body_mask(const WorkVolume& scan);

/// CT number at the skin, half way between air and soft tissue, Hounsfield units.
inline constexpr int skin_edge_hu = -400;

}  // namespace borelli
