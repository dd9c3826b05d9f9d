// Connected pieces of the body in each axial slice, for example trunk and arms, two legs, or a head.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/proposal/coarse_body.hpp"

namespace borelli {

/// A piece of one slice, connected by edges. Lengths in mm, areas in voxels.
struct SlicePiece {
  std::int32_t slice = 0;
  std::int32_t voxels = 0, bone = 0, lung = 0;
  std::int32_t bones = 0;  ///< connected pieces of its bone, of 2 voxels and more
  double centre_x = 0, centre_y = 0;
  std::int32_t width = 0, depth = 0;  ///< of its bounding box, mm
};

struct SlicePieces {
  struct Slice {
    std::int32_t voxels = 0;
    std::int32_t pieces = 0;  ///< of 2 cm^2 and more
    double centre_x = 0, centre_y = 0;
  };
  std::vector<std::int32_t> number;  ///< by offset: index into `list`; -1 outside the body
  std::vector<SlicePiece> list;
  std::vector<Slice> slices;  ///< by k
};

SlicePieces slice_pieces(const CoarseBody& body);

}  // namespace borelli
