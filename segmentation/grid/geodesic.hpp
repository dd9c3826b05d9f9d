// Shortest paths through a volume whose voxels differ in cost.
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

inline constexpr float no_path = std::numeric_limits<float>::infinity();

/// Cost of each voxel that paths may enter. Cost and length lie side by side, since both are read together.
/// The system gives zeroed memory, and 0 means closed: so voxels that stay closed are never written.
struct Places {
  struct Place {
    float cost;    ///< 0: closed
    float length;  ///< of the best path so far
  };
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };
  Grid grid;
  int threads;  ///< number of threads; 0: all of the machine's
  std::unique_ptr<Place[], Free> place;
  float cheapest = no_path;
  /// By voxel offset: bit set of the seed kinds that may enter; 0: any. Null: any seed may enter any voxel.
  const std::uint8_t* kind = nullptr;
  std::array<std::uint8_t, 32> kind_of_seed{};  ///< by label, one bit

  bool lets_in(std::size_t o, std::uint8_t label) const {
    return !kind || kind[o] == 0 || (kind[o] & kind_of_seed[label]);
  }

  /// `cost_at(offset)` gives each cost, no_path if closed; called in `of_threads` threads.
  template <class Cost>
  Places(const Grid& of, int of_threads, const Cost& cost_at)
      : grid(of),
        threads(of_threads),
        place(static_cast<Place*>(std::calloc(of.count() + 1, sizeof(Place)))) {
    if (!place) throw std::bad_alloc();
    std::mutex mutex;
    in_slabs(static_cast<std::int64_t>(of.count()), of_threads, [&](std::int64_t first, std::int64_t last) {
      float least = no_path;
      for (auto o = static_cast<std::size_t>(first); o < static_cast<std::size_t>(last); ++o) {
        const float here = cost_at(o);
        if (here == no_path) continue;
        least = std::min(least, here);
        place[o] = {here, no_path};
      }
      const std::lock_guard lock(mutex);
      cheapest = std::min(cheapest, least);
    });
  }
  Places(const Volume<float>& cost, int of_threads)
      : Places(cost.grid, of_threads, [&](std::size_t o) { return cost.voxels[o]; }) {}
};

/// Cheapest paths from labelled seeds.
class Geodesic {
 public:
  Volume<std::uint8_t> owner;  ///< label of the seed at the path's start, 0 if unreached

  /// Cost of the cheapest path from a seed to the voxel at an offset, no_path if unreached.
  float length(std::size_t o) const { return owner.voxels[o] ? length_[o] : no_path; }
  float length(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return length(owner.grid.offset(i, j, k));
  }
  /// Makes the voxel a start of paths, with this label and length.
  void begin_at(std::size_t o, std::uint8_t label, float length) {
    owner.voxels[o] = label, length_[o] = length;
    if (!step_.empty()) step_[o] = at_seed;
  }
  /// Takes over owners and lengths of the voxels that are nearer to the other's seeds; not the paths.
  void take_nearer(const Geodesic& other);
  /// Takes over the other's paths, whatever their lengths.
  void take_paths(Geodesic&& other) { step_ = std::move(other.step_); }
  /// Offsets along the path from a seed to the voxel `to`, the seed first; needs kept paths. If paths from
  /// two seeds are equally long up to rounding, it may begin at the one that is not the owner.
  std::vector<std::uint32_t> path_to(std::uint32_t to) const;

 private:
  friend Geodesic geodesic(Places, const Volume<std::uint8_t>&, bool, float);
  static constexpr std::uint8_t at_seed = 13;  // the one of the 27 steps that marks a path's start

  std::unique_ptr<float[], Places::Free> length_;  // valid where there is an owner
  std::vector<std::uint8_t> step_;                 // last step of each path; empty: paths were not kept
};

/// Dijkstra's cheapest paths from labelled seeds (label > 0) over the 26 neighbours of each voxel of an
/// isotropic grid, with a bucket queue (Dial 1969, CACM 12:632). A step costs its length in mm times the mean
/// of the costs (more than 0) at its two ends; voxels of infinite cost are closed. Paths longer than
/// `longest` are not followed.
Geodesic geodesic(Places places, const Volume<std::uint8_t>& seeds, bool keep_paths, float longest = no_path);

/// The owners of `geodesic` alone.
Volume<std::uint8_t> nearest_seeds(Places places, const Volume<std::uint8_t>& seeds, float longest = no_path);

}  // namespace borelli
