#include "segmentation/grid/squared_distances.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "threads/slabs.hpp"

#define BORELLI_INLINE inline __attribute__((always_inline))

namespace borelli {
namespace {

// Adjacent lines side by side, one lane each, as many as fit into a cache line.
template <class Word>
struct alignas(64) Row {
  static constexpr std::int64_t lanes = 64 / sizeof(Word);
  Word at[lanes];
};

// `count` adjacent lines (at most Row::lanes) of `n` voxels, `stride` apart in memory
template <class Word>
struct Lines {
  Word* data;
  std::int64_t n, stride, count;
  Word cap;
  std::int64_t longest;  // largest p whose square is below the cap
  bool outside_is_near;
};

template <class Vector>
BORELLI_INLINE bool any(const Vector& mask) {
  std::uint64_t words[sizeof(Vector) / 8], joined = 0;
  std::memcpy(words, &mask, sizeof mask);
  for (const std::uint64_t word : words) joined |= word;
  return joined != 0;
}

// Replaces f(q) by the minimum of f(q + p) + p^2; `f` is scratch space of n rows. Vectors have `bytes`, at
// most the register width: GCC emulates wider ones through memory.
template <int bytes, class Word>
BORELLI_INLINE void least_along(const Lines<Word>& lines, Row<Word>* f) {
  typedef Word Lanes __attribute__((vector_size(bytes)));
  constexpr std::int64_t width = bytes / sizeof(Word);
  const auto read = [&](std::int64_t first, std::int64_t q, Lanes & out) __attribute__((always_inline)) {
    std::memcpy(&out, f[q].at + first, bytes);
  };
  const Lanes zero{}, cap = zero + lines.cap;
  for (std::int64_t q = 0; q < lines.n; ++q) {
    const Word* const from = lines.data + q * lines.stride;
    if (lines.count == Row<Word>::lanes) {
      std::memcpy(f[q].at, from, sizeof f[q].at);
    } else {
      f[q] = {};
      std::memcpy(f[q].at, from, sizeof(Word) * static_cast<std::size_t>(lines.count));
    }
  }
  for (std::int64_t first = 0; first < lines.count; first += width) {
    bool far = true;
    for (std::int64_t q = 0; q < lines.n && far; ++q) {
      Lanes own;
      read(first, q, own);
      far = !any(own < cap);
    }
    if (far && !lines.outside_is_near) continue;
    const std::int64_t kept = std::min(width, lines.count - first);
    for (std::int64_t q = 0; q < lines.n; ++q) {
      Lanes best, other;
      read(first, q, best);
      if (lines.outside_is_near) {
        const std::int64_t edge = std::min(q + 1, lines.n - q);
        other = zero + static_cast<Word>(std::min<std::int64_t>(edge * edge, lines.cap));
        best = other < best ? other : best;
      }
      const std::int64_t last = std::min(std::max(q, lines.n - 1 - q), lines.longest);
      for (std::int64_t p = 1; p <= last; ++p) {
        const auto square = static_cast<Word>(p * p);
        if (p % 4 == 1 && !any(best > square)) break;
        if (q >= p) {
          read(first, q - p, other);
          other += square;
          best = other < best ? other : best;
        }
        if (q + p < lines.n) {
          read(first, q + p, other);
          other += square;
          best = other < best ? other : best;
        }
      }
      Word* const to = lines.data + q * lines.stride + first;
      if (kept == width)
        std::memcpy(to, &best, bytes);
      else
        std::memcpy(to, &best, sizeof(Word) * static_cast<std::size_t>(kept));
    }
  }
}

// One portable build that still uses the machine's widest vectors.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
template <class Word>
[[gnu::target("arch=x86-64-v4")]] void least_by_64(const Lines<Word>& lines, Row<Word>* f) {
  least_along<64>(lines, f);
}
template <class Word>
[[gnu::target("arch=x86-64-v3")]] void least_by_32(const Lines<Word>& lines, Row<Word>* f) {
  least_along<32>(lines, f);
}
#endif

template <class Word>
void least_by_16(const Lines<Word>& lines, Row<Word>* f) {
  least_along<16>(lines, f);
}

template <class Word>
auto least_of(int vector_bytes) {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
  if (vector_bytes >= 64 && __builtin_cpu_supports("x86-64-v4")) return least_by_64<Word>;
  if (vector_bytes >= 32 && __builtin_cpu_supports("x86-64-v3")) return least_by_32<Word>;
#else
  static_cast<void>(vector_bytes);
#endif
  return least_by_16<Word>;
}

// Squared distances within one row: 0 in runs of `near`; elsewhere from the nearer end of the gap. `longest`:
// the least run whose square is not below the cap.
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
  using Room = std::vector<Row<Word>>;
  constexpr std::int64_t lanes = Row<Word>::lanes;
  const auto least = least_of<Word>(options.vector_bytes);
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
        least({&out.voxels[g.offset(i, 0, k)], ny, nx, std::min(lanes, nx - i), cap, longest - 1, outside},
              room.data());
    }
  });
  in_slabs(ny, options.threads, [&](std::int64_t j0, std::int64_t j1) {
    Room room(static_cast<std::size_t>(nz));
    for (std::int64_t j = j0; j < j1; ++j)
      for (std::int64_t i = 0; i < nx; i += lanes)
        least(
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
