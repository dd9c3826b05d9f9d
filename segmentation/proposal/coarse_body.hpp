// The body on a grid of 4 mm, on which the forest labels voxels.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/body/anatomy.hpp"

namespace borelli {

/// Step of the grid that features are computed on, mm. The forest is trained at this step.
inline constexpr double labelling_step = 4;

/// Input of the features. The grid starts at the work grid's first voxel and is parallel to it.
struct CoarseBody {
  Volume<std::int16_t> hu;             ///< mean CT number of each voxel, clamped to -1000 .. 1000
  Mask seen;                           ///< 1 where the scan shows the place
  Mask body, bone;                     ///< the anatomy's masks at the voxel's centre
  std::vector<std::uint8_t> depth;     ///< depth below the skin, mm, up to 200; 0 outside the body
  std::vector<std::uint8_t> off_bone;  ///< distance to bone, mm, up to 60
  std::vector<std::uint32_t> places;   ///< offsets of the body's voxels, ascending
  int threads = 0;                     ///< 0: as many as the machine has

  const Grid& grid() const { return hu.grid; }
};

/// Resamples an anatomy, whose work grid may have any step.
CoarseBody coarse_body(const Anatomy& anatomy);

/// True at voxels that border, by a face, on what the scan does not show.
bool at_scan_end(const CoarseBody& body, std::size_t offset);

}  // namespace borelli
