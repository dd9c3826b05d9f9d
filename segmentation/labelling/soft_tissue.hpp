// The soft tissue layer: which part's flesh each place of the body is, wherever the convention cuts.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/labelling/touching_flesh.hpp"
#include "segmentation/vocabulary/convention.hpp"

namespace borelli {

/// Every body voxel goes to the part whose bone has the cheapest way to it through the body. In lean flesh
/// (see touching_flesh.hpp) a step costs 1 / (1 + d), d the depth below its surface in mm; in fat it is
/// dearer by far, so that a way from arm to trunk where skin touches skin is dear, and where it crosses air
/// the dearest. Fat between an arm and what it touches is shared by its thickness beside. Below the waist the
/// depth misleads (legs touch along a broad deep face, and the pelvis' crest lies shallow), and the plain
/// length of the way decides among pelvis and legs; by `bone` also among the trunk's three parts, which no
/// plane parts there: whose bone is nearest. `bones`: part labels of bone voxels. The result reaches
/// `margin` mm beyond the body.
Volume<std::uint8_t> label_soft_tissue(const Anatomy& anatomy, const LeanFlesh& lean,
                                       const Volume<std::uint8_t>& bones, double margin,
                                       Convention convention);

}  // namespace borelli
