#include <algorithm>
#include <cstring>
#include <numeric>

#include "segmentation/morphology.hpp"

// Regions are joined run by run: a run is a row's voxels [first, last) of the mask without a gap, and those
// that touch in neighbouring rows belong together (He, Chao & Suzuki 2008, IEEE Trans Image Process 17:749).

namespace borelli {
namespace {

struct Run {
  std::int32_t first, last;
};

// every run of a mask, and where each row's begin in the list
struct Runs {
  std::vector<Run> list;
  std::vector<std::size_t> row;  // row[j + ny k], and the list's end

  explicit Runs(const Mask& mask) {
    const std::int64_t nx = mask.grid.size[0], rows = mask.grid.size[1] * mask.grid.size[2];
    row.reserve(static_cast<std::size_t>(rows) + 1);
    for (std::int64_t r = 0; r < rows; ++r) {
      row.push_back(list.size());
      const std::uint8_t* const at = mask.voxels.data() + r * nx;
      for (std::int64_t i = next_set(at, 0, nx); i < nx;) {
        const void* const gap = std::memchr(at + i, 0, static_cast<std::size_t>(nx - i));
        const std::int64_t end = gap ? static_cast<const std::uint8_t*>(gap) - at : nx;
        list.push_back({static_cast<std::int32_t>(i), static_cast<std::int32_t>(end)});
        i = next_set(at, end, nx);
      }
    }
    row.push_back(list.size());
  }

 private:
  static std::int64_t next_set(const std::uint8_t* at, std::int64_t i, std::int64_t n) {
    for (std::uint64_t word; i + 8 <= n; i += 8) {
      std::memcpy(&word, at + i, 8);
      if (word) break;
    }
    while (i < n && !at[i]) ++i;
    return i;
  }
};

// sets of runs, each known by the least of its runs
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::uint32_t of(std::size_t run) {
    auto n = static_cast<std::uint32_t>(run);
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }
  void join(std::size_t a, std::size_t b) {
    const std::uint32_t x = of(a), y = of(b);
    parent_[std::max(x, y)] = std::min(x, y);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// joins the runs of two rows that overlap, or lie no more than `gap` apart along the row
void join_rows(const Runs& runs, std::size_t row, std::size_t other, std::int32_t gap, Sets& sets) {
  std::size_t a = runs.row[row], b = runs.row[other];
  while (a < runs.row[row + 1] && b < runs.row[other + 1]) {
    const Run &x = runs.list[a], &y = runs.list[b];
    if (x.first < y.last + gap && y.first < x.last + gap) sets.join(a, b);
    x.last < y.last ? ++a : ++b;
  }
}

// The runs of the sets of which some run is a `start`.
template <class Start>
Mask sets_with(const Mask& mask, const Runs& runs, Sets& sets, const Start& start) {
  std::vector<bool> has(runs.list.size());
  const auto each = [&](const auto& visit) {
    for (std::size_t row = 0; row + 1 < runs.row.size(); ++row)
      for (std::size_t n = runs.row[row]; n < runs.row[row + 1]; ++n) visit(row, n);
  };
  each([&](std::size_t row, std::size_t n) {
    if (const std::uint32_t set = sets.of(n); !has[set] && start(row, runs.list[n])) has[set] = true;
  });
  Mask out{mask.grid, std::vector<std::uint8_t>(mask.voxels.size(), 0)};
  each([&](std::size_t row, std::size_t n) {
    if (!has[sets.of(n)]) return;
    std::uint8_t* const at = out.voxels.data() + row * static_cast<std::size_t>(mask.grid.size[0]);
    std::fill(at + runs.list[n].first, at + runs.list[n].last, std::uint8_t{1});
  });
  return out;
}

struct RunsOfRegions {
  Runs runs;
  std::vector<std::int32_t> number;  // by run: index into `list`
  std::vector<Region> list;          // largest first
};

RunsOfRegions runs_of_regions(const Mask& mask, int neighbours) {
  const auto& g = mask.grid;
  const std::int64_t ny = g.size[1], nz = g.size[2];
  RunsOfRegions out{Runs(mask), {}, {}};
  const Runs& runs = out.runs;
  Sets sets(runs.list.size());
  const bool corners = neighbours == 26;
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t j = 0; j < ny; ++j) {
      const auto join = [&](std::int64_t b, std::int64_t c) {
        if (b < 0 || b >= ny || c < 0) return;
        join_rows(runs, static_cast<std::size_t>(k * ny + j), static_cast<std::size_t>(c * ny + b),
                  corners ? 1 : 0, sets);
      };
      join(j - 1, k), join(j, k - 1);
      if (corners) join(j - 1, k - 1), join(j + 1, k - 1);
    }

  auto& number = out.number;  // first in the order of the regions' first voxels
  number.resize(runs.list.size());
  std::vector<Region> found;
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t j = 0; j < ny; ++j) {
      const auto row = static_cast<std::size_t>(k * ny + j);
      for (std::size_t n = runs.row[row]; n < runs.row[row + 1]; ++n) {
        const Run& run = runs.list[n];
        const std::uint32_t set = sets.of(n);
        if (set == n) {
          number[n] = static_cast<std::int32_t>(found.size());
          found.push_back({0, {run.first, j, k}, {run.first, j, k}, Eigen::Vector3d::Zero()});
        } else {
          number[n] = number[set];
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

// Writes value_of(run's index) over each run.
template <class T, class Value>
void fill_runs(const Runs& runs, Volume<T>& out, const Value& value_of) {
  for (std::size_t row = 0; row + 1 < runs.row.size(); ++row) {
    const auto at = out.voxels.begin() + static_cast<std::ptrdiff_t>(row) * out.grid.size[0];
    for (std::size_t n = runs.row[row]; n < runs.row[row + 1]; ++n)
      std::fill(at + runs.list[n].first, at + runs.list[n].last, value_of(n));
  }
}

}  // namespace

Regions connected_regions(const Mask& mask, int neighbours) {
  RunsOfRegions regions = runs_of_regions(mask, neighbours);
  Regions out{{mask.grid, std::vector<std::int32_t>(mask.grid.count(), 0)}, std::move(regions.list)};
  fill_runs(regions.runs, out.number, [&](std::size_t n) { return regions.number[n] + 1; });
  return out;
}

Mask kept_regions(const Mask& mask, int neighbours,
                  const std::function<bool(const Region&, const Region&)>& keep) {
  const RunsOfRegions regions = runs_of_regions(mask, neighbours);
  std::vector<std::uint8_t> kept;
  for (const Region& region : regions.list) kept.push_back(keep(region, regions.list[0]));
  Mask out{mask.grid, std::vector<std::uint8_t>(mask.grid.count(), 0)};
  fill_runs(regions.runs, out,
            [&](std::size_t n) { return kept[static_cast<std::size_t>(regions.number[n])]; });
  return out;
}

Mask reached(const Mask& seed, const Mask& mask) {
  const Runs runs(mask);
  Sets sets(runs.list.size());
  const auto ny = static_cast<std::size_t>(mask.grid.size[1]), rows = runs.row.size() - 1;
  for (std::size_t row = 0; row < rows; ++row) {
    if (row % ny > 0) join_rows(runs, row, row - 1, 0, sets);
    if (row >= ny) join_rows(runs, row, row - ny, 0, sets);
  }
  return sets_with(mask, runs, sets, [&](std::size_t row, const Run& run) {
    const std::uint8_t* const at = seed.voxels.data() + row * static_cast<std::size_t>(mask.grid.size[0]);
    return std::any_of(at + run.first, at + run.last, [](std::uint8_t v) { return v != 0; });
  });
}

Mask reached_from_sides(const Mask& mask) {
  const Runs runs(mask);
  Sets sets(runs.list.size());
  const auto ny = static_cast<std::size_t>(mask.grid.size[1]), rows = runs.row.size() - 1;
  for (std::size_t row = 0; row < rows; ++row)
    if (row % ny > 0) join_rows(runs, row, row - 1, 0, sets);
  return sets_with(mask, runs, sets, [&](std::size_t row, const Run& run) {
    return run.first == 0 || run.last == mask.grid.size[0] || row % ny == 0 || row % ny + 1 == ny;
  });
}

}  // namespace borelli
