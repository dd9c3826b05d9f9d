// Which bones move a point of the skin: its place between the cuts of its part's joints.
//
// Around a cut lies a zone that reaches two half thicknesses of the limb into both parts, less where other
// cuts are near. From one end of the zone to the other the joint's swing grows from 0 to 1. A limb of radius
// r that bends by theta over a length l folds inside where 1.25 theta r > l (1.25: the spline's steepest
// slope). The zone's 4 r suffice for 150 degrees of an elbow; the groin, where trunk and thighs leave less
// room, folds beyond about 60 degrees. A twist along a segment grows between the zones at its two ends.
//
// Along a zone weights are quadratic B-splines over the bones (de Boor (1978) "A practical guide to splines",
// chapter 9): continuously differentiable, at most three bones at a place. Distances are lengths of ways
// through the flesh (segmentation/grid/geodesic.hpp).
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
