// Where a body is cut by the scan's end, and not merely beside it.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "segmentation/grid/morphology.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// By part, how much of it meets what the scan does not show, mm^2. A body that merely touches the scan's
/// side shows air beside the place of contact; where it is cut, the section reaches into its depth: what
/// counts lies at least 10 mm and a quarter of the owner's greatest depth below the skin. `owner` labels the
/// body's voxels, `depth` is below the skin in mm (the scan's edge is no skin), `part` the part of a place by
/// its owner. All on one isotropic grid.
std::array<double, 256> edge_contact(const Mask& body, const Mask& seen, const Distances& depth,
                                     const Volume<std::uint8_t>& owner,
                                     const std::function<int(std::uint8_t, const Eigen::Vector3d&)>& part);

/// What of a part meets the edge where it is cut, mm^2; less than that is a touch.
inline constexpr double cut_section = 100;

/// Whether a part ends where the scan does, although it is too slender there for edge_contact: fingers and
/// toes that the scan's end cuts. `places` are the part's voxels, `outwards` its axis towards its tip (unit,
/// along the grid's axes). Beside a face that looks that way a cut end's section is about as large as 10 mm
/// further in, where an end that only touches the face has rounded off.
bool runs_out(const std::vector<std::array<std::int64_t, 3>>& places, const Mask& seen,
              const Eigen::Vector3d& outwards);

/// `edge_contact` of a label map, on a grid of 3 mm: whether a label is cut where its scan ends, or where it
/// holds padding. Labels too thin to be 10 mm deep are cut where they lie on the grid's outer faces with a
/// tenth of the area of a cube of their volume (one held whole just touches; a limb cut across has about a
/// half). Both must lie on one grid.
std::array<bool, 256> cut_labels(const LabelMap& labels, const GreyVolume& scan, int threads = 0);

}  // namespace borelli
