// Finds parts that the scan's edge cuts, as opposed to parts that only touch it.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "segmentation/grid/morphology.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Area of each part, by label, that meets the unseen region, mm^2. A body that only touches the scan's side
/// has air beside the contact. Where the scan cuts a body, the section reaches deep inside. So only voxels
/// count that lie below the skin by at least 10 mm and a quarter of the owner's greatest depth. `owner`:
/// labels of the body's voxels. `depth`: below the skin, mm (the scan's edge is not skin). `part`: the part
/// of a point (LPS, mm) given its owner. All on one isotropic grid.
std::array<double, 256> edge_contact(const Mask& body, const Mask& seen, const Distances& depth,
                                     const Volume<std::uint8_t>& owner,
                                     const std::function<int(std::uint8_t, const Eigen::Vector3d&)>& part);

/// A contact area above this means that the part is cut, mm^2; below, that it only touches the edge.
inline constexpr double cut_section = 100;

/// Whether the scan's end cuts a part that is too slender for edge_contact: fingers and toes. `places`: the
/// part's voxels. `outwards`: its axis towards its tip (unit, along the grid's axes). At a face in that
/// direction, the section of a cut end is about as large as 10 mm further in. An end that only touches the
/// face is rounded there.
bool runs_out(const std::vector<std::array<std::int64_t, 3>>& places, const Mask& seen,
              const Eigen::Vector3d& outwards);

/// edge_contact of a label map, on a grid of 3 mm: whether a label is cut by the scan's end, by padding,
/// or by the end of its label map where tissue goes on behind it. Labels with voxels beyond the scan are cut.
/// Labels less than 10 mm deep are cut if their area on the outer faces of `labels` is at least a tenth of
/// that of a cube of their volume. (A part that lies wholly inside just touches; a limb cut across has about
/// a half.) Both must lie on one grid. `scan`: CT numbers or densities.
std::array<bool, 256> cut_labels(const LabelMap& labels, const GreyVolume& scan, int threads = 0);

}  // namespace borelli
