// Shortest ways through a volume whose places differ in how dear they are to cross.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <vector>

#include "segmentation/slabs.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

inline constexpr float no_way = std::numeric_limits<float>::infinity();

/// What ways may enter. Cost and length are looked at together, side by side; as memory comes from the
/// system, all is closed: what is not entered is not even written.
struct Places {
  struct Place {
    float cost;    ///< 0: closed, since the length is final or the place not to be entered
    float length;  ///< so far
  };
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };
  Grid grid;
  std::unique_ptr<Place[], Free> place;
  float cheapest = no_way;

  /// Costs by offset, asked for by `threads`.
  template <class Cost>
  Places(const Grid& of, int threads, const Cost& cost_at)
      : grid(of), place(static_cast<Place*>(std::calloc(of.count() + 1, sizeof(Place)))) {
    if (!place) throw std::bad_alloc();
    std::mutex mutex;
    in_slabs(static_cast<std::int64_t>(of.count()), threads, [&](std::int64_t first, std::int64_t last) {
      float least = no_way;
      for (auto o = static_cast<std::size_t>(first); o < static_cast<std::size_t>(last); ++o) {
        const float here = cost_at(o);
        if (here == no_way) continue;
        least = std::min(least, here);
        place[o] = {here, no_way};
      }
      const std::lock_guard lock(mutex);
      cheapest = std::min(cheapest, least);
    });
  }
  Places(const Volume<float>& cost)  // NOLINT: a volume of costs is as good
      : Places(cost.grid, 0, [&](std::size_t o) { return cost.voxels[o]; }) {}
};

struct Geodesic {
  Volume<float> length;             ///< cost of the cheapest way from a seed, no_way where there is none
  Volume<std::uint8_t> owner;       ///< label of the seed at the way's start, 0 where there is none
  std::vector<std::uint32_t> from;  ///< offset of the voxel before on the way (a seed: its own), where asked
};

/// Dijkstra's cheapest ways from labelled seeds (label > 0) over the 26 neighbours of each voxel of an
/// isotropic grid, in a bucket queue (Dial 1969, CACM 12:632). A step costs its length in mm times the mean
/// of the costs (more than 0) at its two ends; places of infinite cost are not entered. Ways longer than
/// `longest` are not followed.
Geodesic geodesic(Places places, const Volume<std::uint8_t>& seeds, bool keep_ways, float longest = no_way);

/// Its owners alone.
Volume<std::uint8_t> nearest_seeds(Places places, const Volume<std::uint8_t>& seeds, float longest = no_way);

/// The way from a seed to the voxel at offset `to`, the seed first.
std::vector<std::uint32_t> way_to(const Geodesic& geodesic, std::uint32_t to);

}  // namespace borelli
