// Divides the fat between an arm and what it touches: the trunk, a leg or the other arm.
#pragma once

#include "segmentation/body/anatomy.hpp"

namespace borelli {

/// Muscle, organs and bones: tissue denser than fat and thicker than skin, vessels and fasciae.
struct LeanFlesh {
  Mask mask;
  Distances depth;  ///< below its surface, mm, up to 200
};
LeanFlesh lean_flesh(const Anatomy& anatomy);

/// Relabels the fat between the lean flesh of an arm and that of another part. If the scan shows air or two
/// skins in the fat, the border is there (seen_border.hpp). Usually it shows neither. Then the border follows
/// from each side's fat thickness on free skin beside the contact. If the gap is thinner than both together,
/// each side is compressed in proportion to its fat, except for the skin, which is incompressible. If the gap
/// is thicker, it is divided in proportion.
///
/// `owner`: part labels (parts.hpp) of the body's voxels on the work grid. Lean voxels keep their label. Fat
/// voxels near lean flesh of an arm and of another part are relabelled.
void part_touching_flesh(const Anatomy& anatomy, const Mask& lean, Volume<std::uint8_t>& owner);

}  // namespace borelli
