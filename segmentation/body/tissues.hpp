// What each place of the body is made of, by its CT number.
#pragma once

#include "segmentation/grid/morphology.hpp"
#include "segmentation/grid/work_grid.hpp"

namespace borelli {

enum class Tissue : std::uint8_t { outside, air, lung, fat, soft, bone };

/// Upper ends of the classes, Hounsfield units (Lev & Gonzalez 2002, Brain mapping ch. 17; the lung's range
/// after Kemerink et al. 1998, Med Phys 25:1075). What is above the last one is bone.
inline constexpr int air_to_hu = -950, lung_to_hu = -300, fat_to_hu = -25, soft_to_hu = 160;

constexpr Tissue tissue_of(int hu) {
  return hu < air_to_hu    ? Tissue::air
         : hu < lung_to_hu ? Tissue::lung
         : hu < fat_to_hu  ? Tissue::fat
         : hu < soft_to_hu ? Tissue::soft
                           : Tissue::bone;
}

/// Bones as solids: what is dense as bone, with its marrow (hollows of the mask, closed in space or within a
/// slice and no wider than a marrow cavity), without specks.
Mask bone_mask(const WorkVolume& scan, const Mask& body, int threads = 0);

}  // namespace borelli
