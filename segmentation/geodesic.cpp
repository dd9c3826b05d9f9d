#include "segmentation/geodesic.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace borelli {

namespace {

/// Owners, and `from` (of as many voxels; null: not asked for); lengths where there is an owner stay in
/// `places`.
Volume<std::uint8_t> follow_ways(Places& places, const Volume<std::uint8_t>& seeds, float longest,
                                 std::uint32_t* from) {
  const auto& g = places.grid;
  Places::Place* const place = places.place.get();
  Volume<std::uint8_t> owner{g, std::vector<std::uint8_t>(g.count(), 0)};

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
  for (std::size_t o = 0; o < g.count(); ++o) {
    if (!seeds.voxels[o] || place[o].cost == 0) continue;
    place[o].length = 0;
    owner.voxels[o] = seeds.voxels[o];
    if (from) from[o] = static_cast<std::uint32_t>(o);
    buckets[0].push_back(static_cast<std::uint32_t>(o));
  }
  // buckets as wide as the cheapest step: what is taken from the lowest one is final, save for rounding,
  // which the check against the stored length takes care of
  const float width = std::max(1e-6F, places.cheapest * h);
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
        for (const std::ptrdiff_t row : rows) __builtin_prefetch(place + buckets[b][n + ahead] + row);
      const std::uint32_t o = buckets[b][n];
      const auto [c, here] = place[o];
      if (c == 0) continue;
      place[o].cost = 0;
      const auto i = static_cast<int>(o % nx), j = static_cast<int>(o / nx % ny),
                 k = static_cast<int>(o / nx / ny);
      const bool within =
          i > 0 && j > 0 && k > 0 && i + 1 < g.size[0] && j + 1 < g.size[1] && k + 1 < g.size[2];
      for (const auto& s : steps) {
        if (!within && !g.holds(i + s.i, j + s.j, k + s.k)) continue;
        const auto to = static_cast<std::uint32_t>(static_cast<std::ptrdiff_t>(o) + s.offset);
        if (place[to].cost == 0) continue;
        const float length = here + s.half * (c + place[to].cost);
        if (length >= place[to].length || length > longest) continue;
        place[to].length = length;
        owner.voxels[to] = owner.voxels[o];
        if (from) from[to] = o;
        push(length, to);
      }
    }
    std::vector<std::uint32_t>().swap(buckets[b]);
  }
  return owner;
}

}  // namespace

Geodesic geodesic(Places places, const Volume<std::uint8_t>& seeds, bool keep_ways, float longest) {
  const Grid& g = places.grid;
  Geodesic out;
  if (keep_ways) out.from.resize(g.count());
  out.owner = follow_ways(places, seeds, longest, keep_ways ? out.from.data() : nullptr);
  out.length = {g, std::vector<float>(g.count(), no_way)};
  for (std::size_t o = 0; o < g.count(); ++o)
    if (out.owner.voxels[o]) out.length.voxels[o] = places.place[o].length;
  return out;
}

Volume<std::uint8_t> nearest_seeds(Places places, const Volume<std::uint8_t>& seeds, float longest) {
  return follow_ways(places, seeds, longest, nullptr);
}

std::vector<std::uint32_t> way_to(const Geodesic& geodesic, std::uint32_t to) {
  std::vector<std::uint32_t> way{to};
  while (geodesic.from[way.back()] != way.back()) way.push_back(geodesic.from[way.back()]);
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace borelli
