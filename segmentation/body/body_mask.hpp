// Which places of a scan are the person: table, clothes and air around it taken away, lungs and gut kept.
#pragma once

#include "segmentation/grid/morphology.hpp"
#include "segmentation/grid/work_grid.hpp"

namespace borelli {

/// 1 inside the body. Steps: what is denser than fat's air edge; thin wide sheets (table shells, blankets) go
/// by their shape, small thin things (ears, fingers, toes) stay, and so does a small piece that holds bone
/// within flesh close beside the body (a thumb that a crevice parts from the palm, joined by a row of
/// voxels); hollows that reach the outside air only through narrow passages, or not at all, are filled
/// (lungs, airways, gut), also where the scan's end opens them; crevices between skin and skin stay open.
/// Several pieces remain where the scan's edge cut limbs off.
Mask body_mask(const WorkVolume& scan);

/// CT number that parts air from tissue at a skin of average softness (half way), Hounsfield units.
inline constexpr int skin_edge_hu = -400;

}  // namespace borelli
