// The soft tissue layer: which part's flesh each place of the body is, wherever the convention cuts.
#pragma once

#include "segmentation/anatomy.hpp"

namespace borelli {

/// Every body voxel goes to the part whose bone has the cheapest way to it through the body. A step costs
/// 1 / (1 + d), d the depth below the skin in mm: where skin touches skin a way from arm to trunk must pass a
/// shallow place and is dear. Below the waist the depth misleads (legs touch along a broad deep face, and the
/// pelvis' crest lies shallow), and the plain length of the way decides among pelvis and legs. `bones`: part
/// labels of bone voxels. The result reaches `margin` mm beyond the body.
Volume<std::uint8_t> label_soft_tissue(const Anatomy& anatomy, const Volume<std::uint8_t>& bones,
                                       double margin);

}  // namespace borelli
