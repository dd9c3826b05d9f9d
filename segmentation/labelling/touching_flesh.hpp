// Where an arm lies on the trunk, a leg or the other arm: whose fat is between them.
#pragma once

#include "segmentation/body/anatomy.hpp"

namespace borelli {

/// Muscle, organs and bones: what is denser than fat and thicker than skin, vessels and fasciae are.
struct LeanFlesh {
  Mask mask;
  Distances depth;  ///< below its surface, mm, up to 200
};
LeanFlesh lean_flesh(const Anatomy& anatomy);

/// Between lean flesh of an arm and that of another part lies the fat of both, and where
/// the scan shows air or two skins in it, there is the border (seen_border.hpp). Mostly it shows none. But
/// how thick either's fat is shows beside the contact, where the skin is free: the border leaves each of them
/// as much as it has there. Where the two together are pressed thinner, each gives in proportion to what it
/// has, save for the skin itself, which does not give; where there is more, it is shared in proportion.
///
/// `owner`: part labels (parts.hpp) of the body's voxels on the work grid; lean voxels keep theirs, fat ones
/// near lean flesh both of an arm and of what is not that arm are given anew.
void part_touching_flesh(const Anatomy& anatomy, const Mask& lean, Volume<std::uint8_t>& owner);

}  // namespace borelli
