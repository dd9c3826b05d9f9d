// Squared distances in voxels from each voxel to the nearest one of a mask: whole numbers, exact.
#pragma once

#include <cstdint>

#include "segmentation/volume/volume.hpp"

namespace borelli {

struct DistanceOptions {
  bool to_unset = false;         ///< to the nearest voxel that is not set, in place of the nearest set one
  bool outside_is_near = false;  ///< what lies outside the grid counts as such a voxel
  int threads = 0;               ///< 0: as many as the machine has
  int vector_bytes = 64;         ///< in vectors of no more than these: 16, 32 or 64
};

/// Squared distance of each voxel to the nearest voxel of the kind asked for, and `cap` where it is more.
/// Axis by axis: the least of f(q + p) + p^2 over p (Felzenszwalb & Huttenlocher 2012, Theory of Computing
/// 8:415), not by their lower envelope but by trying p = 1, 2 ... up to where p^2 alone is more than what
/// was found, for many lines side by side. So the time grows with the distances, which `cap` bounds.
/// `Word`: std::uint16_t where 2 cap fits into it, else std::uint32_t.
template <class Word>
Volume<Word> squared_distances(const Volume<std::uint8_t>& mask, Word cap, const DistanceOptions& options);

extern template Volume<std::uint16_t> squared_distances(const Volume<std::uint8_t>&, std::uint16_t,
                                                        const DistanceOptions&);
extern template Volume<std::uint32_t> squared_distances(const Volume<std::uint8_t>&, std::uint32_t,
                                                        const DistanceOptions&);

}  // namespace borelli
