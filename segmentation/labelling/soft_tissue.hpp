// The soft tissue layer: the part whose flesh each body voxel is, before the convention's planes cut.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/labelling/touching_flesh.hpp"
#include "segmentation/vocabulary/convention.hpp"

namespace borelli {

/// Assigns every body voxel to the part whose bone has the cheapest path to it through the body. `bones`: part
/// labels of bone voxels. The result extends `margin` mm beyond the body.
///
/// In lean flesh (see touching_flesh.hpp) a step costs 1 / (1 + d), with d the depth below its surface in mm.
/// Fat costs far more, so paths from arm to trunk across touching skin are expensive; voxels with air between
/// limbs cost most. Fat between an arm and what it touches is divided by the fat's thickness beside the
/// contact.
///
/// Below the waist depth is misleading: legs touch along a broad deep face, and the iliac crest is shallow.
/// So pelvis and legs are divided by plain path length. With `bone` the trunk's three parts are too, since no
/// plane separates them.
Volume<std::uint8_t> label_soft_tissue(const Anatomy& anatomy, const LeanFlesh& lean,
                                       const Volume<std::uint8_t>& bones, double margin,
                                       Convention convention);

}  // namespace borelli
