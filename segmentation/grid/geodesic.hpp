// Shortest ways through a volume whose places differ in how dear they are to cross.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "segmentation/volume/volume.hpp"
#include "threads/slabs.hpp"

namespace borelli {

inline constexpr float no_way = std::numeric_limits<float>::infinity();

/// What ways may enter. Cost and length are looked at together, side by side; as memory comes from the
/// system, all is closed: what is not entered is not even written.
struct Places {
  struct Place {
    float cost;    ///< 0: not to be entered
    float length;  ///< so far
  };
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };
  Grid grid;
  int threads;  ///< that ways may be followed by; 0: as many as the machine has
  std::unique_ptr<Place[], Free> place;
  float cheapest = no_way;
  /// Of each voxel, by offset: only seeds of these kinds (bits) may reach it; 0: any may. Null: any may reach
  /// all.
  const std::uint8_t* kind = nullptr;
  std::array<std::uint8_t, 32> kind_of_seed{};  ///< by label, one bit

  bool lets_in(std::size_t o, std::uint8_t label) const {
    return !kind || kind[o] == 0 || (kind[o] & kind_of_seed[label]);
  }

  /// Costs by offset, asked for by `of_threads`.
  template <class Cost>
  Places(const Grid& of, int of_threads, const Cost& cost_at)
      : grid(of),
        threads(of_threads),
        place(static_cast<Place*>(std::calloc(of.count() + 1, sizeof(Place)))) {
    if (!place) throw std::bad_alloc();
    std::mutex mutex;
    in_slabs(static_cast<std::int64_t>(of.count()), of_threads, [&](std::int64_t first, std::int64_t last) {
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
  Places(const Volume<float>& cost, int of_threads)
      : Places(cost.grid, of_threads, [&](std::size_t o) { return cost.voxels[o]; }) {}
};

/// Cheapest ways from labelled seeds.
class Geodesic {
 public:
  Volume<std::uint8_t> owner;  ///< label of the seed at the way's start, 0 where there is none

  /// Cost of the cheapest way from a seed to the voxel at an offset, no_way where there is none.
  float length(std::size_t o) const { return owner.voxels[o] ? length_[o] : no_way; }
  float length(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return length(owner.grid.offset(i, j, k));
  }
  /// Says that the way to a voxel begins there, however long it was before.
  void begin_at(std::size_t o, std::uint8_t label, float length) {
    owner.voxels[o] = label, length_[o] = length;
    if (!step_.empty()) step_[o] = at_seed;
  }
  /// Takes over owners and lengths of the voxels that are nearer to the other's seeds; not the ways there.
  void take_nearer(const Geodesic& other);
  /// Takes over the other's ways, of whatever length.
  void take_ways(Geodesic&& other) { step_ = std::move(other.step_); }
  /// The way from a seed to the voxel at offset `to`, the seed first, where ways were kept. Where ways from
  /// two seeds are equally long but for rounding, it may begin at the one that is not the owner.
  std::vector<std::uint32_t> way_to(std::uint32_t to) const;

 private:
  friend Geodesic geodesic(Places, const Volume<std::uint8_t>&, bool, float);
  static constexpr std::uint8_t at_seed = 13;  // of 27 steps, the one to where it began

  std::unique_ptr<float[], Places::Free> length_;  // where there is an owner
  std::vector<std::uint8_t> step_;                 // the way's last one; empty: ways were not kept
};

/// Dijkstra's cheapest ways from labelled seeds (label > 0) over the 26 neighbours of each voxel of an
/// isotropic grid, in a bucket queue (Dial 1969, CACM 12:632). A step costs its length in mm times the mean
/// of the costs (more than 0) at its two ends; places of infinite cost are not entered. Ways longer than
/// `longest` are not followed.
Geodesic geodesic(Places places, const Volume<std::uint8_t>& seeds, bool keep_ways, float longest = no_way);

/// Its owners alone.
Volume<std::uint8_t> nearest_seeds(Places places, const Volume<std::uint8_t>& seeds, float longest = no_way);

}  // namespace borelli
