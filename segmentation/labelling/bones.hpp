// The bone layer: the part of each bone, independent of the convention that cuts the flesh.
#pragma once

#include <array>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {

/// Label (see parts.hpp) of every bone voxel, 0 elsewhere. Seeds lie along each limb's path between its
/// joints, in the femoral and humeral heads, and in the trunk's bones. They grow through bone, and deep bone
/// is cheaper than thin bone. Bones that thick slices or arthritis fuse therefore separate at their joint,
/// the narrowest place. The planes divide the trunk's bones. A part without bones in view gets no label here.
Volume<std::uint8_t> label_bones(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs,
                                 const PartPlanes& planes);

}  // namespace borelli
