// Shortest ways through a volume whose places differ in how dear they are to cross.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "segmentation/slabs.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

inline constexpr float no_way = std::numeric_limits<float>::infinity();

/// Costs by offset, filled by `threads`.
template <class Cost>
Volume<float> costs(const Grid& grid, int threads, const Cost& cost_at) {
  Volume<float> out{grid, std::vector<float>(grid.count())};
  in_slabs(std::ssize(out.voxels), threads, [&](std::int64_t first, std::int64_t last) {
    for (auto o = static_cast<std::size_t>(first); o < static_cast<std::size_t>(last); ++o)
      out.voxels[o] = cost_at(o);
  });
  return out;
}

struct Geodesic {
  Volume<float> length;             ///< cost of the cheapest way from a seed, no_way where there is none
  Volume<std::uint8_t> owner;       ///< label of the seed at the way's start, 0 where there is none
  std::vector<std::uint32_t> from;  ///< offset of the voxel before on the way (a seed: its own), where asked
};

/// Dijkstra's cheapest ways from labelled seeds (label > 0) over the 26 neighbours of each voxel of an
/// isotropic grid, in a bucket queue (Dial 1969, CACM 12:632). A step costs its length in mm times the mean
/// of `cost` (more than 0) at its two ends; voxels of infinite cost are not entered. Ways longer than
/// `longest` are not followed.
Geodesic geodesic(const Volume<float>& cost, const Volume<std::uint8_t>& seeds, bool keep_ways,
                  float longest = no_way);

/// Its owners alone.
Volume<std::uint8_t> nearest_seeds(const Volume<float>& cost, const Volume<std::uint8_t>& seeds,
                                   float longest = no_way);

/// The way from a seed to the voxel at offset `to`, the seed first.
std::vector<std::uint32_t> way_to(const Geodesic& geodesic, std::uint32_t to);

}  // namespace borelli
