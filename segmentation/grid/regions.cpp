#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <mutex>
#include <numeric>

#include "segmentation/grid/morphology.hpp"

// Regions are joined by runs: a run is a gapless stretch [first, last) of the mask in a row. Runs that touch
// in neighbouring rows belong together (He, Chao & Suzuki 2008, IEEE Trans Image Process 17:749). Slabs of
// slices are joined within themselves first, then across their borders.

namespace borelli {
namespace {

struct Run {
  std::int32_t first, last;
};

// all runs of a mask, and the index of each row's first run
struct Runs {
  std::vector<Run> list;
  std::vector<std::size_t> row;  // row[j + ny k], and the list's size at the end

  Runs(const Mask& mask, int threads) {
    const std::int64_t nx = mask.grid.size[0], rows = mask.grid.size[1] * mask.grid.size[2];
    row.resize(static_cast<std::size_t>(rows) + 1);
    std::map<std::int64_t, std::vector<Run>> slabs;  // by their first rows
    std::mutex mutex;
    in_slabs(rows, threads, [&](std::int64_t first, std::int64_t last) {
      std::vector<Run> own;
      for (std::int64_t r = first; r < last; ++r) {
        row[static_cast<std::size_t>(r)] = own.size();
        add_row(mask.voxels.data() + r * nx, nx, own);
      }
      const std::lock_guard lock(mutex);
      slabs[first] = std::move(own);
    });
    for (auto slab = slabs.begin(); slab != slabs.end(); ++slab) {
      const auto next = std::next(slab);
      const auto end = static_cast<std::size_t>(next == slabs.end() ? rows : next->first);
      for (auto r = static_cast<std::size_t>(slab->first); r < end; ++r) row[r] += list.size();
      if (list.empty())
        list = std::move(slab->second);
      else
        list.insert(list.end(), slab->second.begin(), slab->second.end());
    }
    row.back() = list.size();
  }

 private:
  static void add_row(const std::uint8_t* at, std::int64_t nx, std::vector<Run>& list) {
    for (std::int64_t i = next_set(at, 0, nx); i < nx;) {
      const void* const gap = std::memchr(at + i, 0, static_cast<std::size_t>(nx - i));
      const std::int64_t end = gap ? static_cast<const std::uint8_t*>(gap) - at : nx;
      list.push_back({static_cast<std::int32_t>(i), static_cast<std::int32_t>(end)});
      i = next_set(at, end, nx);
    }
  }
  static std::int64_t next_set(const std::uint8_t* at, std::int64_t i, std::int64_t n) {
    for (std::uint64_t word; i + 8 <= n; i += 8) {
      std::memcpy(&word, at + i, 8);
      if (word) break;
    }
    while (i < n && !at[i]) ++i;
    return i;
  }
};

// disjoint sets of runs, each represented by its run of least index
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }

  // parallel calls must concern disjoint sets
  void join(std::size_t a, std::size_t b) {
    const std::uint32_t x = of(a), y = of(b);
    parent_[std::max(x, y)] = std::min(x, y);
  }

  // by run: the least run of its set
  std::vector<std::uint32_t> least() && {
    for (std::uint32_t& parent : parent_) parent = parent_[parent];  // the parent is resolved already
    return std::move(parent_);
  }

 private:
  std::uint32_t of(std::size_t run) {
    auto n = static_cast<std::uint32_t>(run);
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }

  std::vector<std::uint32_t> parent_;
};

// joins the runs of two rows that overlap (gap 0) or also touch at corners (gap 1)
void join_rows(const Runs& runs, std::int64_t row, std::int64_t other, std::int32_t gap, Sets& sets) {
  const std::size_t *const of_row = runs.row.data() + row, *const of_other = runs.row.data() + other;
  std::size_t a = of_row[0], b = of_other[0];
  while (a < of_row[1] && b < of_other[1]) {
    const Run &x = runs.list[a], &y = runs.list[b];
    if (x.first < y.last + gap && y.first < x.last + gap) sets.join(a, b);
    x.last < y.last ? ++a : ++b;
  }
}

enum class Touch { faces_in_slice, faces, corners };

// By run: the least run of its connected region.
std::vector<std::uint32_t> joined(const Runs& runs, const Grid& grid, Touch touch, int threads) {
  const std::int64_t ny = grid.size[1], nz = grid.size[2];
  const bool corners = touch == Touch::corners;
  Sets sets(runs.list.size());
  const auto join = [&](std::int64_t row, std::int64_t j, std::int64_t k) {
    if (j >= 0 && j < ny) join_rows(runs, row, k * ny + j, corners ? 1 : 0, sets);
  };
  const auto join_slice_before = [&](std::int64_t k) {
    for (std::int64_t j = 0; j < ny; ++j) {
      join(k * ny + j, j, k - 1);
      if (corners) join(k * ny + j, j - 1, k - 1), join(k * ny + j, j + 1, k - 1);
    }
  };
  std::vector<std::int64_t> seams;
  std::mutex mutex;
  in_slabs(nz, threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) {
      for (std::int64_t j = 1; j < ny; ++j) join(k * ny + j, j - 1, k);
      if (k > first && touch != Touch::faces_in_slice) join_slice_before(k);
    }
    const std::lock_guard lock(mutex);
    if (first > 0 && first < last && touch != Touch::faces_in_slice) seams.push_back(first);
  });
  for (const std::int64_t k : seams) join_slice_before(k);
  return std::move(sets).least();
}

// Calls visit(row, run's index) for each run; slabs of rows in parallel.
template <class Visit>
void each_run(const Runs& runs, int threads, const Visit& visit) {
  in_slabs(std::ssize(runs.row) - 1, threads, [&](std::int64_t first, std::int64_t last) {
    for (auto row = static_cast<std::size_t>(first); row < static_cast<std::size_t>(last); ++row)
      for (std::size_t n = runs.row[row]; n < runs.row[row + 1]; ++n) visit(row, n);
  });
}

// A mask with value_of(run's index) over each run.
template <class Value>
Mask mask_of(const Grid& grid, const Runs& runs, int threads, const Value& value_of) {
  Mask out{grid, std::vector<std::uint8_t>(grid.count(), 0)};
  each_run(runs, threads, [&](std::size_t row, std::size_t n) {
    std::uint8_t* const at = out.voxels.data() + row * static_cast<std::size_t>(grid.size[0]);
    std::fill(at + runs.list[n].first, at + runs.list[n].last, std::uint8_t{value_of(n)});
  });
  return out;
}

// The sets that contain a run for which start(row, run) is true.
template <class Start>
Mask sets_with(const Mask& mask, Touch touch, const Start& start) {
  const Runs runs(mask, 0);
  const std::vector<std::uint32_t> set = joined(runs, mask.grid, touch, 0);
  std::vector<std::uint8_t> has(runs.list.size());
  each_run(runs, 0, [&](std::size_t row, std::size_t n) {
    const std::atomic_ref own(has[set[n]]);
    if (!own.load(std::memory_order_relaxed) && start(row, runs.list[n]))
      own.store(1, std::memory_order_relaxed);
  });
  return mask_of(mask.grid, runs, 0, [&](std::size_t n) { return has[set[n]]; });
}

struct RunsOfRegions {
  Runs runs;
  std::vector<std::int32_t> number;  // by run: index into `list`
  std::vector<Region> list;          // largest first
};

RunsOfRegions runs_of_regions(const Mask& mask, int neighbours, int threads) {
  const std::int64_t ny = mask.grid.size[1], nz = mask.grid.size[2];
  RunsOfRegions out{Runs(mask, threads), {}, {}};
  const Runs& runs = out.runs;
  const std::vector<std::uint32_t> set =
      joined(runs, mask.grid, neighbours == 26 ? Touch::corners : Touch::faces, threads);

  auto& number = out.number;  // numbered at first in the order of the regions' first voxels
  number.resize(runs.list.size());
  std::vector<Region> found;
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t j = 0; j < ny; ++j) {
      const auto row = static_cast<std::size_t>(k * ny + j);
      for (std::size_t n = runs.row[row]; n < runs.row[row + 1]; ++n) {
        const Run& run = runs.list[n];
        if (set[n] == n) {
          number[n] = static_cast<std::int32_t>(found.size());
          found.push_back({0, {run.first, j, k}, {run.first, j, k}, Eigen::Vector3d::Zero()});
        } else {
          number[n] = number[set[n]];
        }
        Region& region = found[static_cast<std::size_t>(number[n])];
        const std::int64_t count = run.last - run.first, twice_middle = run.first + run.last - 1;
        region.voxels += count;
        region.low = {std::min<std::int64_t>(region.low[0], run.first), std::min(region.low[1], j),
                      std::min(region.low[2], k)};
        region.high = {std::max<std::int64_t>(region.high[0], run.last - 1), std::max(region.high[1], j),
                       std::max(region.high[2], k)};
        region.centre += Eigen::Vector3d(static_cast<double>(count * twice_middle / 2),
                                         static_cast<double>(count * j), static_cast<double>(count * k));
      }
    }
  for (Region& region : found) region.centre /= static_cast<double>(region.voxels);

  std::vector<std::int32_t> order(found.size()), rank(found.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return found[static_cast<std::size_t>(a)].voxels > found[static_cast<std::size_t>(b)].voxels;
  });
  for (std::size_t n = 0; n < order.size(); ++n) {
    out.list.push_back(found[static_cast<std::size_t>(order[n])]);
    rank[static_cast<std::size_t>(order[n])] = static_cast<std::int32_t>(n);
  }
  for (std::int32_t& n : number) n = rank[static_cast<std::size_t>(n)];
  return out;
}

}  // namespace

Regions connected_regions(const Mask& mask, int neighbours, int threads) {
  RunsOfRegions regions = runs_of_regions(mask, neighbours, threads);
  const Runs& runs = regions.runs;
  const auto nx = static_cast<std::size_t>(mask.grid.size[0]);
  Regions out{{mask.grid, std::make_unique_for_overwrite<std::int32_t[]>(mask.grid.count())},
              std::move(regions.list)};
  in_slabs(std::ssize(runs.row) - 1, threads, [&](std::int64_t first, std::int64_t last) {
    for (auto row = static_cast<std::size_t>(first); row < static_cast<std::size_t>(last); ++row) {
      std::int32_t* const at = out.number.voxels.get() + row * nx;
      std::fill_n(at, nx, 0);
      for (std::size_t n = runs.row[row]; n < runs.row[row + 1]; ++n)
        std::fill(at + runs.list[n].first, at + runs.list[n].last, regions.number[n] + 1);
    }
  });
  return out;
}

Mask kept_regions(const Mask& mask, int neighbours,
                  const std::function<bool(const Region&, const Region&)>& keep) {
  const RunsOfRegions regions = runs_of_regions(mask, neighbours, 0);
  std::vector<std::uint8_t> kept;
  for (const Region& region : regions.list) kept.push_back(keep(region, regions.list[0]));
  return mask_of(mask.grid, regions.runs, 0,
                 [&](std::size_t n) { return kept[static_cast<std::size_t>(regions.number[n])]; });
}

Mask reached(const Mask& seed, const Mask& mask) {
  return sets_with(mask, Touch::faces, [&](std::size_t row, const Run& run) {
    const std::uint8_t* const at = seed.voxels.data() + row * static_cast<std::size_t>(mask.grid.size[0]);
    return std::any_of(at + run.first, at + run.last, [](std::uint8_t v) { return v != 0; });
  });
}

Mask reached_from_sides(const Mask& mask) {
  const auto ny = static_cast<std::size_t>(mask.grid.size[1]);
  return sets_with(mask, Touch::faces_in_slice, [&](std::size_t row, const Run& run) {
    return run.first == 0 || run.last == mask.grid.size[0] || row % ny == 0 || row % ny + 1 == ny;
  });
}

}  // namespace borelli
