// Walls that keep paths from one limb's seeds out of voxels that surely belong to another limb.
#pragma once

#include <array>
#include <cstdint>

#include "segmentation/grid/geodesic.hpp"
#include "segmentation/proposal/proposal.hpp"

namespace borelli {

/// By label of the seeds: their kind, one bit of five.
using SeedKinds = std::array<std::uint8_t, 32>;

/// Kind of an index into body_limbs. Head and trunk share a kind, since a plane cuts the neck.
constexpr std::uint8_t wall_kind(std::size_t limb) {
  return limb == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(1U << (limb == 1 ? 2U : limb));
}

/// By label of parts.hpp.
inline constexpr SeedKinds kind_of_part = [] {
  SeedKinds kinds{};
  for (std::size_t label = 1; label < parts.size(); ++label)
    kinds[label] = wall_kind(limb_of_part(static_cast<int>(label)));
  return kinds;
}();

/// By index into body_limbs: bit set of the seed kinds that may enter a voxel that is surely of that limb.
/// Usually only its own kind; both sides' kinds if the two arms or the two legs touch. Paths along bones then
/// decide the side, and not the forest.
std::array<std::uint8_t, body_limbs.size()> kinds_let_in(const Proposal& proposal);

/// Sets the anatomy's walls from its proposal.
void put_walls(Anatomy& anatomy);

/// The same places with the anatomy's walls, if it has any.
inline Places walled(const Anatomy& a, Places places, const SeedKinds& kind_of_seed) {
  if (a.wall.empty()) return places;
  places.kind = a.wall.data();
  places.kind_of_seed = kind_of_seed;
  return places;
}

}  // namespace borelli
