// Exact squared distances, in voxels, from each voxel to the nearest one of a mask.
#pragma once

#include <cstdint>

#include "segmentation/volume/volume.hpp"

namespace borelli {

struct DistanceOptions {
  bool to_unset = false;  ///< measure to the nearest voxel that is not set, instead of the nearest set one
  bool outside_is_near = false;  ///< voxels outside the grid count as targets
  int threads = 0;               ///< 0: all of the machine's
  int vector_bytes = 64;         ///< largest SIMD vector to use, bytes: 16, 32 or 64
};

/// Squared distance of each voxel to the nearest target voxel, clamped to `cap`. Axis by axis it takes the
/// minimum of f(q + p) + p^2 over p (Felzenszwalb & Huttenlocher 2012, Theory of Computing 8:415). Instead of
/// their lower envelope it tries p = 1, 2 ... until p^2 exceeds the minimum found, for many lines in
/// parallel. So the time grows with the distances, which `cap` bounds. `Word`: std::uint16_t if 2 cap fits
/// into it, else std::uint32_t.
template <class Word>
Volume<Word> squared_distances(const Volume<std::uint8_t>& mask, Word cap, const DistanceOptions& options);

extern template Volume<std::uint16_t> squared_distances(const Volume<std::uint8_t>&, std::uint16_t,
                                                        const DistanceOptions&);
extern template Volume<std::uint32_t> squared_distances(const Volume<std::uint8_t>&, std::uint32_t,
                                                        const DistanceOptions&);

}  // namespace borelli
