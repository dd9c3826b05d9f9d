// Places where the skins of two parts touch. A label map shows no air there, although no flesh joins the two.
#pragma once

#include <vector>

#include "pipeline/export/skin.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Whether flesh joins parts a and b (indices) at a place, m: they have a joint there. The cut between upper
/// arm and trunk lies around the shoulder; further down the arm only touches the trunk. So flesh joins the
/// parts at places within two half thicknesses of the joint's centre along the part's axis, and within four
/// in all directions.
bool flesh_joins(const std::vector<SkinPart>& parts, std::size_t a, std::size_t b,
                 const Eigen::Vector3d& p_W);

/// Opens a gap of one voxel between parts that touch without a joint: sets these voxels of the larger part to
/// 0. `body`: voxels are part indices + 1, 0 is air. No gap is opened within 10 mm of a third part that has
/// joints with both, since three cuts meet there.
void open_contacts(Volume<std::uint8_t>& body, const std::vector<SkinPart>& parts);

}  // namespace borelli
