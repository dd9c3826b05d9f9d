// The bone layer: which part each bone belongs to, whatever the convention that cuts the flesh.
#pragma once

#include <array>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {

/// Label (see parts.hpp) of every bone voxel, 0 elsewhere. Seeds stand along each limb's way between its
/// joints, in the heads at its root, and in the trunk's own bones; they grow through bone where it is deep
/// more cheaply than where it is thin, so that bones which thick slices or arthritis fuse part at their
/// joint, the narrowest place. The trunk's bones are parted by its planes. A part without bones in view has
/// no label here.
Volume<std::uint8_t> label_bones(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs,
                                 const PartPlanes& planes);

}  // namespace borelli
