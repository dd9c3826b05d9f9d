// The last step of segmentation: labels on the scan's own voxels.
#pragma once

#include <cstdint>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/labelling/class_parts.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Labels on the scan's own voxels. At the skin the voxel's own value decides whether it is body, in hollows
/// the work grid's mask. The part follows from the flesh's owner on the work grid and the planes at the
/// voxel's centre. Classes (may be null) override both.
LabelMap label_voxels(const GreyVolume& volume, const Anatomy& a, const Volume<std::uint8_t>& owner,
                      const PartPlanes& planes, const ClassParts* classes, const AbsentParts& absent,
                      int threads);

}  // namespace borelli
