// Which bones move a point of the skin. They follow from the point's place between the cuts of its part's
// joints.
//
// Around a cut lies a zone that reaches two half thicknesses of the limb into both parts, less where the
// parent's other cuts are near. From one end of the zone to the other the joint's swing grows steadily from 0
// to 1. Skin at a distance d from the joint's axis folds inside where theta d > l, for a bend by theta over a
// length l. Zones of joints to one part overlap (groin, shoulders, waist): a place there takes shares of all
// of them. A twist along a segment grows between the zones at its two ends.
//
// Along a zone weights are linear between the two bones next to a place: the least slope, so the least
// folding. Distances are lengths of paths through the flesh (segmentation/grid/geodesic.hpp).
#pragma once

#include "pipeline/export/skin.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Parts first, then the helpers of each joint in the order from the parent to the part.
std::vector<SkinBone> skin_bones(const std::vector<SkinPart>& parts, int helpers);

/// Sets bones and weights of every point of the skin's mesh. `body`: part indices + 1, without contacts
/// (skin_contacts.hpp); `coarse`: the same on the isotropic grid.
void weigh_points(Skin& skin, const Volume<std::uint8_t>& body, const Volume<std::uint8_t>& coarse,
                  const SkinOptions& options);

}  // namespace borelli
