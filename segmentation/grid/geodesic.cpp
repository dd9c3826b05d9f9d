#include "segmentation/grid/geodesic.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace borelli {

namespace {

// The 27 steps to a voxel's neighbours and to itself, in memory order: step 9 c + 3 b + a leads by (a, b, c)
// - (1, 1, 1).
constexpr int steps_to_all = 27;

std::ptrdiff_t offset_of(int step, const Grid& g) {
  return ((step / 9 - 1) * g.size[1] + step / 3 % 3 - 1) * g.size[0] + step % 3 - 1;
}

// Three neighbours adjacent in memory, processed together; the fourth lane is unused.
typedef float Four __attribute__((vector_size(16)));
typedef std::int32_t FourWords __attribute__((vector_size(16)));

struct NeighbourRow {
  std::ptrdiff_t offset;  // of its first neighbour
  Four half;              // half of each step's length, mm
  FourWords bit;          // one per step, but none for the voxel itself
};

std::array<NeighbourRow, 9> rows_about(const Grid& g) {
  const auto h = static_cast<float>(g.axes.col(0).norm());
  std::array<NeighbourRow, 9> rows{};
  for (int step = 0; step < steps_to_all; ++step) {
    NeighbourRow& row = rows[static_cast<std::size_t>(step) / 3];
    const int a = step % 3 - 1, b = step / 3 % 3 - 1, c = step / 9 - 1;
    row.half[step % 3] = 0.5F * h * std::sqrt(static_cast<float>(a * a + b * b + c * c));
    if (a || b || c) row.bit[step % 3] = 1 << step;
    if (a < 0) row.offset = offset_of(step, g);
  }
  return rows;
}

// Follows paths within some of the grid's columns (i from `first` to before `last`), from given starts. A
// voxel whose path becomes shorter is expanded again, so `follow` may be called again with paths that come
// from other columns.
class Paths {
 public:
  /// Updates owners, and the step by which each voxel is reached (null: not recorded), along with the
  /// lengths.
  Paths(Places& places, float longest, std::uint8_t* owner, std::uint8_t* by_step, std::int64_t first,
        std::int64_t last)
      : places_(places),
        grid_(places.grid),
        place_(places.place.get()),
        owner_(owner),
        by_step_(by_step),
        longest_(longest),
        // buckets as wide as the cheapest step: paths from the lowest bucket are final up to rounding
        width_(std::max(1e-6F, places.cheapest * static_cast<float>(places.grid.axes.col(0).norm()))),
        first_(first),
        last_(last),
        count_(static_cast<std::ptrdiff_t>(places.grid.count())),
        rows_(rows_about(places.grid)) {
    for (int step = 0; step < steps_to_all; ++step)
      offset_[static_cast<std::size_t>(step)] = offset_of(step, grid_);
  }

  /// Starts a path at a voxel, with this length so far and this last step.
  void begin(std::size_t to, float length, std::uint8_t label, std::uint8_t step) {
    place_[to].length = length;
    push({static_cast<std::uint32_t>(to), length, label, step});
  }

  void follow() {
    for (std::size_t b = 0; b < buckets_.size(); ++b) {
      for (std::size_t n = 0; n < buckets_[b].size(); ++n) {
        constexpr std::size_t ahead = 4;  // prefetch the neighbours of this later entry
        if (n + ahead < buckets_[b].size())
          for (const NeighbourRow& row : rows_)
            __builtin_prefetch(place_ + buckets_[b][n + ahead].to + row.offset);
        const Path path = buckets_[b][n];
        if (place_[path.to].length != path.length) continue;
        owner_[path.to] = path.label;
        if (by_step_) by_step_[path.to] = path.step;
        go_on(path);
      }
      std::vector<Path>().swap(buckets_[b]);
    }
    buckets_.clear();
  }

 private:
  // A path to a voxel; skipped if a shorter one was found later.
  struct Path {
    std::uint32_t to;
    float length;
    std::uint8_t label, step;
  };

  void push(const Path& path) {
    constexpr float most_buckets = 1 << 20;
    const auto n = static_cast<std::size_t>(std::min(most_buckets - 1, path.length / width_));
    if (n >= buckets_.size()) buckets_.resize(n + 1);
    buckets_[n].push_back(path);
  }

  void go_on(const Path& path) {
    const auto at = static_cast<std::ptrdiff_t>(path.to);
    const std::int64_t i = at % grid_.size[0];
    const bool all_there =
        i > first_ && i + 2 < last_ && at + offset_.front() >= 0 && at + offset_.back() + 1 < count_;
    std::array<Four, 9> length;
    std::uint32_t steps =
        all_there
            ? nearer(path, length, [&](std::ptrdiff_t from) { return place_ + from; })
            : nearer(path, length, [&, some = std::array<Places::Place, 4>()](std::ptrdiff_t from) mutable {
                some = {};  // closed if out of reach
                for (std::ptrdiff_t a = 0; a < 3; ++a)
                  if (i - 1 + a >= first_ && i - 1 + a < last_ && from + a >= 0 && from + a < count_)
                    some[static_cast<std::size_t>(a)] = place_[from + a];
                return some.data();
              });
    if (!steps) return;
    const std::int64_t j = at / grid_.size[0] % grid_.size[1];  // beyond a side lies another slice's row
    if (j == 0) steps &= ~steps_with([](int step) { return step / 3 % 3 == 0; });
    if (j + 1 == grid_.size[1]) steps &= ~steps_with([](int step) { return step / 3 % 3 == 2; });
    for (; steps; steps &= steps - 1) {
      const auto step = static_cast<std::size_t>(std::countr_zero(steps));
      const auto to = static_cast<std::size_t>(at + offset_[step]);
      if (!places_.lets_in(to, path.label)) continue;
      begin(to, length[step / 3][step % 3], path.label, static_cast<std::uint8_t>(step));
    }
  }

  template <class Which>
  static constexpr std::uint32_t steps_with(const Which& which) {
    std::uint32_t steps = 0;
    for (int step = 0; step < steps_to_all; ++step)
      if (which(step)) steps |= 1U << step;
    return steps;
  }

  /// Steps by which a neighbour's path becomes shorter, as bits, and `length` of each such path.
  /// `places_from`: pointer to four adjacent places, given the first one's offset.
  template <class PlacesFrom>
  std::uint32_t nearer(const Path& path, std::array<Four, 9>& length, PlacesFrom&& places_from) const {
    const float cost_here = place_[path.to].cost;
    FourWords bits{};
#pragma GCC unroll 9
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Places::Place* const four = places_from(static_cast<std::ptrdiff_t>(path.to) + rows_[r].offset);
      Four first, second;
      std::memcpy(&first, four, sizeof first);
      std::memcpy(&second, four + 2, sizeof second);
      const Four cost = __builtin_shufflevector(first, second, 0, 2, 4, 6),
                 so_far = __builtin_shufflevector(first, second, 1, 3, 5, 7);
      length[r] = path.length + rows_[r].half * (cost_here + cost);
      bits |= (length[r] < so_far) & (length[r] <= longest_) & (cost != 0) & rows_[r].bit;
    }
    return static_cast<std::uint32_t>(bits[0] | bits[1] | bits[2]);
  }

  const Places& places_;
  const Grid& grid_;
  Places::Place* place_;
  std::uint8_t *owner_, *by_step_;
  float longest_, width_;
  std::int64_t first_, last_;  // columns
  std::ptrdiff_t count_;
  std::array<NeighbourRow, 9> rows_;
  std::array<std::ptrdiff_t, steps_to_all> offset_;
  std::vector<std::vector<Path>> buckets_;  // by length
};

/// Owners, from cheapest paths. `by_step` (one per voxel; null: not recorded): the step by which each voxel
/// is reached, `at_seed` at seeds. The lengths of voxels with an owner stay in `places`.
Volume<std::uint8_t> follow_paths(Places& places, const Volume<std::uint8_t>& seeds, float longest,
                                  std::uint8_t* by_step, std::uint8_t at_seed) {
  const auto& g = places.grid;
  Volume<std::uint8_t> owner{g, std::vector<std::uint8_t>(g.count(), 0)};
  // Splits a large volume into halves that run in parallel, then expands the paths that cross the middle. For
  // a body along the grid few paths do.
  constexpr std::size_t large = 1 << 20;
  const std::int64_t nx = g.size[0], rows = g.size[1] * g.size[2],
                     middle = nx < 2 || g.count() < large ? nx : nx / 2;
  const auto each = [&](std::int64_t first, std::int64_t last, const auto& visit) {
    for (std::int64_t r = 0; r < rows; ++r)
      for (std::int64_t i = first; i < last; ++i) visit(static_cast<std::size_t>(r * nx + i));
  };
  const auto paths_in = [&](std::int64_t first, std::int64_t last) {
    return Paths(places, longest, owner.voxels.data(), by_step, first, last);
  };
  in_slabs(middle < nx ? 2 : 1, places.threads, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t half = from; half < to; ++half) {
      const std::int64_t first = half == 0 ? 0 : middle, last = half == 0 ? middle : nx;
      Paths paths = paths_in(first, last);
      each(first, last, [&](std::size_t o) {
        if (seeds.voxels[o] && places.place[o].cost != 0 && places.lets_in(o, seeds.voxels[o]))
          paths.begin(o, 0, seeds.voxels[o], at_seed);
      });
      paths.follow();
    }
  });
  if (middle < nx) {
    Paths paths = paths_in(0, nx);
    each(middle - 1, middle + 1, [&](std::size_t o) {
      if (owner.voxels[o])
        paths.begin(o, places.place[o].length, owner.voxels[o], by_step ? by_step[o] : at_seed);
    });
    paths.follow();
  }
  return owner;
}

}  // namespace

Geodesic geodesic(Places places, const Volume<std::uint8_t>& seeds, bool keep_paths, float longest) {
  const Grid& g = places.grid;
  Geodesic out;
  if (keep_paths) out.step_.resize(g.count());
  out.owner =
      follow_paths(places, seeds, longest, keep_paths ? out.step_.data() : nullptr, Geodesic::at_seed);
  // moves the lengths to the front of the memory that they shared with the costs, and frees the rest
  auto* const memory = reinterpret_cast<unsigned char*>(places.place.release());
  for (std::size_t o = 0; o < g.count(); ++o)
    if (out.owner.voxels[o])
      std::memcpy(memory + o * sizeof(float),
                  memory + o * sizeof(Places::Place) + offsetof(Places::Place, length), sizeof(float));
  void* const less = std::realloc(memory, (g.count() + 1) * sizeof(float));
  out.length_.reset(static_cast<float*>(less ? less : memory));
  return out;
}

Volume<std::uint8_t> nearest_seeds(Places places, const Volume<std::uint8_t>& seeds, float longest) {
  return follow_paths(places, seeds, longest, nullptr, 0);
}

void Geodesic::take_nearer(const Geodesic& other) {
  for (std::size_t o = 0; o < owner.voxels.size(); ++o)
    if (other.length(o) < length(o)) owner.voxels[o] = other.owner.voxels[o], length_[o] = other.length_[o];
}

std::vector<std::uint32_t> Geodesic::path_to(std::uint32_t to) const {
  std::vector<std::uint32_t> path{to};
  while (step_[path.back()] != at_seed)
    path.push_back(static_cast<std::uint32_t>(path.back() - offset_of(step_[path.back()], owner.grid)));
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace borelli
