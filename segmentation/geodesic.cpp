#include "segmentation/geodesic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>

namespace borelli {

namespace {

/// What is looked at together, side by side. As memory comes from the system, closed: what is not entered
/// is not even written.
struct Place {
  float cost;    ///< 0: closed, since the length is final or the place not to be entered
  float length;  ///< so far
};
struct Free {
  void operator()(void* memory) const { std::free(memory); }
};
using Places = std::unique_ptr<Place[], Free>;

/// Owners, lengths where there is an owner, and `from` (of as many voxels; null: not asked for).
Places follow_ways(const Volume<float>& cost, const Volume<std::uint8_t>& seeds, float longest,
                   Volume<std::uint8_t>& owner, std::uint32_t* from) {
  const auto& g = cost.grid;
  owner = {g, std::vector<std::uint8_t>(g.count(), 0)};
  Places places(static_cast<Place*>(std::calloc(std::max<std::size_t>(1, g.count()), sizeof(Place))));
  if (!places) throw std::bad_alloc();

  struct Step {
    int i, j, k;
    std::ptrdiff_t offset;
    float half;  // half the step's length, mm
  };
  std::vector<Step> steps;
  const auto h = static_cast<float>(g.axes.col(0).norm());
  for (int c = -1; c <= 1; ++c)
    for (int b = -1; b <= 1; ++b)
      for (int a = -1; a <= 1; ++a)
        if (a || b || c)
          steps.push_back({a, b, c, (c * g.size[1] + b) * g.size[0] + a,
                           0.5F * h * std::sqrt(static_cast<float>(a * a + b * b + c * c))});

  std::vector<std::vector<std::uint32_t>> buckets(1);
  float cheapest = no_way;
  for (std::size_t o = 0; o < g.count(); ++o) {
    const float here = cost.voxels[o];
    if (here == no_way) continue;
    cheapest = std::min(cheapest, here);
    places[o] = {here, no_way};
    if (!seeds.voxels[o]) continue;
    places[o].length = 0;
    owner.voxels[o] = seeds.voxels[o];
    if (from) from[o] = static_cast<std::uint32_t>(o);
    buckets[0].push_back(static_cast<std::uint32_t>(o));
  }
  // buckets as wide as the cheapest step: what is taken from the lowest one is final, save for rounding,
  // which the check against the stored length takes care of
  const float width = std::max(1e-6F, cheapest * h);
  constexpr std::size_t most_buckets = 1 << 20;
  const auto push = [&](float length, std::uint32_t o) {
    const std::size_t n = std::min(most_buckets - 1, static_cast<std::size_t>(length / width));
    if (n >= buckets.size()) buckets.resize(n + 1);
    buckets[n].push_back(o);
  };

  // places whose neighbours' rows are fetched while those before them are looked at
  constexpr std::size_t ahead = 4;
  std::array<std::ptrdiff_t, 9> rows;
  for (std::ptrdiff_t r = 0; r < 9; ++r) rows[r] = ((r / 3 - 1) * g.size[1] + r % 3 - 1) * g.size[0];

  const auto nx = static_cast<std::uint32_t>(g.size[0]), ny = static_cast<std::uint32_t>(g.size[1]);
  for (std::size_t b = 0; b < buckets.size(); ++b) {
    for (std::size_t n = 0; n < buckets[b].size(); ++n) {
      if (n + ahead < buckets[b].size())
        for (const std::ptrdiff_t row : rows) __builtin_prefetch(places.get() + buckets[b][n + ahead] + row);
      const std::uint32_t o = buckets[b][n];
      const auto [c, here] = places[o];
      if (c == 0) continue;
      places[o].cost = 0;
      const auto i = static_cast<int>(o % nx), j = static_cast<int>(o / nx % ny),
                 k = static_cast<int>(o / nx / ny);
      const bool within =
          i > 0 && j > 0 && k > 0 && i + 1 < g.size[0] && j + 1 < g.size[1] && k + 1 < g.size[2];
      for (const auto& s : steps) {
        if (!within && !g.holds(i + s.i, j + s.j, k + s.k)) continue;
        const auto to = static_cast<std::uint32_t>(static_cast<std::ptrdiff_t>(o) + s.offset);
        Place& place = places[to];
        if (place.cost == 0) continue;
        const float length = here + s.half * (c + place.cost);
        if (length >= place.length || length > longest) continue;
        place.length = length;
        owner.voxels[to] = owner.voxels[o];
        if (from) from[to] = o;
        push(length, to);
      }
    }
    std::vector<std::uint32_t>().swap(buckets[b]);
  }
  return places;
}

}  // namespace

Geodesic geodesic(const Volume<float>& cost, const Volume<std::uint8_t>& seeds, bool keep_ways,
                  float longest) {
  const auto& g = cost.grid;
  Geodesic out{{g, std::vector<float>(g.count(), no_way)}, {}, {}};
  if (keep_ways) out.from.resize(g.count());
  const Places places = follow_ways(cost, seeds, longest, out.owner, keep_ways ? out.from.data() : nullptr);
  for (std::size_t o = 0; o < g.count(); ++o)
    if (out.owner.voxels[o]) out.length.voxels[o] = places[o].length;
  return out;
}

Volume<std::uint8_t> nearest_seeds(const Volume<float>& cost, const Volume<std::uint8_t>& seeds,
                                   float longest) {
  Volume<std::uint8_t> owner;
  follow_ways(cost, seeds, longest, owner, nullptr);
  return owner;
}

std::vector<std::uint32_t> way_to(const Geodesic& geodesic, std::uint32_t to) {
  std::vector<std::uint32_t> way{to};
  while (geodesic.from[way.back()] != way.back()) way.push_back(geodesic.from[way.back()]);
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace borelli
