#include "segmentation/squared_distances.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "segmentation/slabs.hpp"

// One portable build that still uses the machine's widest vectors: the loader picks the clone that it can
// run, and what is marked INLINE is compiled anew within each.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define BORELLI_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BORELLI_VECTOR_CLONES
#endif
#define BORELLI_INLINE inline __attribute__((always_inline))

namespace borelli {
namespace {

// Neighbouring lines side by side, one lane each.
template <class Word>
struct Strip {
  static constexpr std::int64_t lanes = 64 / sizeof(Word);
  typedef Word Lanes __attribute__((vector_size(64), aligned(64)));
  struct Row {
    Lanes at;
  };
};

// lines of `n` voxels, `stride` apart in memory, `count` of them beside each other (at most Strip::lanes)
template <class Word>
struct Lines {
  Word* data;
  std::int64_t n, stride, count;
  Word cap;
  std::int64_t longest;  // whose square is below the cap
  bool outside_is_near;
};

template <class Vector>
BORELLI_INLINE bool any(const Vector& mask) {
  std::uint64_t words[8], joined = 0;
  std::memcpy(words, &mask, 64);
  for (const std::uint64_t word : words) joined |= word;
  return joined != 0;
}

// replaces f(q) by the least of f(q + p) + p^2; `f` is room for n rows
template <class Word>
BORELLI_INLINE void least_along(const Lines<Word>& lines, typename Strip<Word>::Row* f) {
  using Lanes = typename Strip<Word>::Lanes;
  const auto copy = [&](void* to, const void* from) __attribute__((always_inline)) {
    if (lines.count == Strip<Word>::lanes)
      std::memcpy(to, from, 64);
    else
      std::memcpy(to, from, sizeof(Word) * static_cast<std::size_t>(lines.count));
  };
  const Lanes zero{}, cap = zero + lines.cap;
  bool far = true;
  for (std::int64_t q = 0; q < lines.n; ++q) {
    f[q].at = zero;
    copy(&f[q].at, lines.data + q * lines.stride);
    far = far && !any(f[q].at < cap);
  }
  if (far && !lines.outside_is_near) return;
  for (std::int64_t q = 0; q < lines.n; ++q) {
    Lanes best = f[q].at;
    if (lines.outside_is_near) {
      const std::int64_t edge = std::min(q + 1, lines.n - q);
      const Lanes square = zero + static_cast<Word>(std::min<std::int64_t>(edge * edge, lines.cap));
      best = square < best ? square : best;
    }
    const std::int64_t last = std::min(std::max(q, lines.n - 1 - q), lines.longest);
    for (std::int64_t p = 1; p <= last; ++p) {
      const auto square = static_cast<Word>(p * p);
      if (p % 4 == 1 && !any(best > square)) break;
      if (q >= p) {
        const Lanes below = f[q - p].at + square;
        best = below < best ? below : best;
      }
      if (q + p < lines.n) {
        const Lanes above = f[q + p].at + square;
        best = above < best ? above : best;
      }
    }
    copy(lines.data + q * lines.stride, &best);
  }
}

BORELLI_VECTOR_CLONES
void least_of(const Lines<std::uint16_t>& lines, Strip<std::uint16_t>::Row* f) { least_along(lines, f); }
BORELLI_VECTOR_CLONES
void least_of(const Lines<std::uint32_t>& lines, Strip<std::uint32_t>::Row* f) { least_along(lines, f); }

// Squared distances within one row: 0 in runs of `near`, and between them from the nearer of their two ends.
// `longest`: the least run whose square is not below the cap.
template <class Word>
void along_row(const std::uint8_t* row, std::int64_t n, std::uint8_t near, Word cap, std::int64_t longest,
               bool outside_is_near, Word* out) {
  const auto find = [&](std::int64_t from, std::uint8_t value) {
    const void* const found = std::memchr(row + from, value, static_cast<std::size_t>(n - from));
    return found ? static_cast<const std::uint8_t*>(found) - row : n;
  };
  const auto other = static_cast<std::uint8_t>(near ? 0 : 1);
  for (std::int64_t i = 0; i < n;) {
    const std::int64_t gap = i, end = find(i, near);
    const int length = static_cast<int>(end - gap);
    const int before = gap > 0 || outside_is_near ? 1 : static_cast<int>(longest);
    const int after = end < n || outside_is_near ? 1 : static_cast<int>(longest);
    const int most = static_cast<int>(longest), top = static_cast<int>(cap);
    for (int t = 0; t < length; ++t) {
      const int d = std::min({before + t, after + length - 1 - t, most});
      out[gap + t] = static_cast<Word>(std::min(d * d, top));
    }
    i = end < n ? find(end, other) : n;
    std::fill(out + end, out + i, Word{0});
  }
}

}  // namespace

template <class Word>
Volume<Word> squared_distances(const Volume<std::uint8_t>& mask, Word cap, const DistanceOptions& options) {
  using Room = std::vector<typename Strip<Word>::Row>;
  constexpr std::int64_t lanes = Strip<Word>::lanes;
  const auto& g = mask.grid;
  const std::int64_t nx = g.size[0], ny = g.size[1], nz = g.size[2];
  Volume<Word> out{g, std::vector<Word>(g.count())};
  std::int64_t longest = 1;
  while (longest * longest < cap) ++longest;
  const bool outside = options.outside_is_near;
  in_slabs(nz, options.threads, [&](std::int64_t k0, std::int64_t k1) {
    Room room(static_cast<std::size_t>(ny));
    for (std::int64_t k = k0; k < k1; ++k) {
      for (std::int64_t j = 0; j < ny; ++j) {
        const std::size_t row = g.offset(0, j, k);
        along_row(&mask.voxels[row], nx, options.to_unset ? 0 : 1, cap, longest, outside, &out.voxels[row]);
      }
      for (std::int64_t i = 0; i < nx; i += lanes)
        least_of({&out.voxels[g.offset(i, 0, k)], ny, nx, std::min(lanes, nx - i), cap, longest - 1, outside},
                 room.data());
    }
  });
  in_slabs(ny, options.threads, [&](std::int64_t j0, std::int64_t j1) {
    Room room(static_cast<std::size_t>(nz));
    for (std::int64_t j = j0; j < j1; ++j)
      for (std::int64_t i = 0; i < nx; i += lanes)
        least_of(
            {&out.voxels[g.offset(i, j, 0)], nz, nx * ny, std::min(lanes, nx - i), cap, longest - 1, outside},
            room.data());
  });
  return out;
}

template Volume<std::uint16_t> squared_distances(const Volume<std::uint8_t>&, std::uint16_t,
                                                 const DistanceOptions&);
template Volume<std::uint32_t> squared_distances(const Volume<std::uint8_t>&, std::uint32_t,
                                                 const DistanceOptions&);

}  // namespace borelli
