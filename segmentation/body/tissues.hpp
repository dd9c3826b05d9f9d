// Tissue of each voxel of the body, by its CT number.
#pragma once

#include "segmentation/grid/morphology.hpp"
#include "segmentation/grid/work_grid.hpp"

namespace borelli {

enum class Tissue : std::uint8_t { outside, air, lung, fat, soft, bone };

/// Upper limits of the classes, Hounsfield units (Lev & Gonzalez 2002, Brain mapping ch. 17; lung from
/// Kemerink et al. 1998, Med Phys 25:1075). Bone lies above the last one.
inline constexpr int air_to_hu = -950, lung_to_hu = -300, fat_to_hu = -25, soft_to_hu = 160;

constexpr Tissue tissue_of(int hu) {
  return hu < air_to_hu    ? Tissue::air
         : hu < lung_to_hu ? Tissue::lung
         : hu < fat_to_hu  ? Tissue::fat
         : hu < soft_to_hu ? Tissue::soft
                           : Tissue::bone;
}

/// Bones as solids: voxels as dense as bone and their marrow, without specks. Marrow: hollows of the mask
/// that are closed within a slice along any axis and no larger than a marrow cavity's section.
Mask bone_mask(const WorkVolume& scan, const Mask& body, int threads = 0);

}  // namespace borelli
