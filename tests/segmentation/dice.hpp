// The agreement of two label maps, part by part.
#pragma once

#include <array>

#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Dice's coefficient per part of maps on the same grid; 1 if neither has the part.
inline std::array<double, parts.size()> dice(const LabelMap& a, const LabelMap& b) {
  std::array<double, parts.size()> both{}, all{};
  for (std::size_t o = 0; o < a.voxels.size(); ++o) {
    if (a.voxels[o] == b.voxels[o]) both[a.voxels[o]] += 2;
    ++all[a.voxels[o]];
    ++all[b.voxels[o]];
  }
  for (std::size_t n = 0; n < both.size(); ++n) both[n] = all[n] > 0 ? both[n] / all[n] : 1;
  return both;
}

/// The share of the exact map's labelled voxels whose label in `found`, on the same grid, is right.
inline double share_right(const LabelMap& found, const LabelMap& exact) {
  double right = 0, all = 0;
  for (std::size_t o = 0; o < exact.voxels.size(); ++o)
    if (exact.voxels[o]) ++all, right += found.voxels[o] == exact.voxels[o];
  return all > 0 ? right / all : 1;
}

}  // namespace borelli
