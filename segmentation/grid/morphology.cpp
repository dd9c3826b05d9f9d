#include "segmentation/grid/morphology.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/grid/squared_distances.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

// The least integer d with h sqrt(d) >= reach, at most 1e9.
std::uint32_t cap_for(double reach, double h) {
  const auto least = static_cast<float>(reach);
  const double about = std::min(reach / h * (reach / h), 1e9);
  auto cap = static_cast<std::uint32_t>(std::max(0.0, about * (1 - 1e-5) - 1));
  while (cap < 1000000000 && static_cast<float>(h) * std::sqrt(static_cast<float>(cap)) < least) ++cap;
  return cap;
}

// out(d) for the squared distance d of each voxel
template <class Out, class Word, class Map>
Volume<Out> mapped(const Volume<Word>& squares, int threads, const Map& map) {
  Volume<Out> out{squares.grid, std::vector<Out>(squares.voxels.size())};
  in_slabs(static_cast<std::int64_t>(squares.voxels.size()), threads,
           [&](std::int64_t from, std::int64_t to) {
             std::transform(squares.voxels.begin() + from, squares.voxels.begin() + to,
                            out.voxels.begin() + from, map);
           });
  return out;
}

template <class Out, class Map>
Volume<Out> map_squares(const Mask& mask, std::uint32_t cap, const DistanceOptions& options, const Map& map) {
  if (2 * cap < 65536)
    return mapped<Out>(squared_distances(mask, static_cast<std::uint16_t>(cap), options), options.threads,
                       map);
  return mapped<Out>(squared_distances(mask, cap, options), options.threads, map);
}

// 1 where the distance is within the radius (`beyond`: where it is not)
Mask within(const Mask& mask, double radius, bool beyond, const DistanceOptions& options) {
  const double h = mask.grid.axes.col(0).norm();
  const auto r = static_cast<float>(radius);
  std::uint32_t first_beyond = cap_for(radius, h);
  if (static_cast<float>(h) * std::sqrt(static_cast<float>(first_beyond)) <= r) ++first_beyond;
  return map_squares<std::uint8_t>(mask, first_beyond, options, [=](std::uint32_t d) {
    return static_cast<std::uint8_t>((d >= first_beyond) == beyond);
  });
}

}  // namespace

Distances distance_to(const Mask& mask, double reach, bool outside_is_set, int threads) {
  constexpr std::uint32_t most = 65535;
  const auto h = static_cast<float>(mask.grid.axes.col(0).norm());
  const std::uint32_t cap = std::min(cap_for(reach, h), most);
  const DistanceOptions options{false, outside_is_set, threads};
  Distances out{mask.grid, {}, h, static_cast<std::uint16_t>(cap), static_cast<float>(reach)};
  if (2 * cap <= most)
    out.squares = squared_distances(mask, out.too_far, options).voxels;
  else
    out.squares = mapped<std::uint16_t>(squared_distances(mask, cap, options), threads, [](std::uint32_t d) {
                    return static_cast<std::uint16_t>(d);
                  }).voxels;
  return out;
}

Mask complement(const Mask& mask) {
  return where(mask.grid, [&](std::size_t o) { return mask.voxels[o] == 0; });
}

Mask eroded(const Mask& mask, double radius, bool outside_is_set) {
  return within(mask, radius, true, {true, !outside_is_set});
}

Mask dilated(const Mask& mask, double radius) { return within(mask, radius, false, {}); }

}  // namespace borelli
