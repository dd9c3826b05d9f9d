// Where the skin of one part touches another's: a label map shows no air there, though nothing joins the two.
#pragma once

#include <vector>

#include "pipeline/export/skin.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Whether flesh joins parts a and b (indices) at a place, m: they have a joint there. The cut between upper
/// arm and trunk lies around the shoulder; further down the arm lies at the trunk. So a joint joins what is
/// at most two half thicknesses from its centre along the part's axis, and at most four in all.
bool flesh_joins(const std::vector<SkinPart>& parts, std::size_t a, std::size_t b,
                 const Eigen::Vector3d& p_W);

/// Opens a gap of one voxel between parts that touch without a joint: sets these voxels of the larger part to
/// 0. `body`: voxels are part indices + 1, 0 is air. Within 10 mm of a third part that has joints with both
/// nothing is opened: three cuts meet there.
void open_contacts(Volume<std::uint8_t>& body, const std::vector<SkinPart>& parts);

}  // namespace borelli
