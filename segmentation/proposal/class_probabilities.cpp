#include "segmentation/proposal/class_probabilities.hpp"

#include <algorithm>
#include <array>

#include "segmentation/vocabulary/parts.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

constexpr std::uint8_t sure = 204;  // 0.8 in 255ths
constexpr std::int32_t no_place = -1;

Result<void> check_fits(const Forest& forest) {
  if (forest.features != voxel_feature_names())
    return failure("forest", "was trained with other features than this program uses; train it again");
  if (!std::equal(forest.classes.begin(), forest.classes.end(), voxel_classes.begin(), voxel_classes.end()))
    return failure("forest", "was trained with other classes than this program uses; train it again");
  return {};
}

// evaluates the forest at one place
void evaluate(const VoxelFeatures& features, const Forest& forest, std::size_t place, std::uint8_t* out) {
  std::array<std::int16_t, 256> row;
  std::array<std::uint32_t, voxel_class_count> sums;
  features.fill(features.body().places[place], std::span(row).first(voxel_feature_names().size()));
  forest.add_up(row, sums);
  const auto trees = static_cast<std::uint32_t>(forest.trees());
  for (std::size_t c = 0; c < voxel_class_count; ++c)
    out[c] = static_cast<std::uint8_t>((sums[c] + trees / 2) / trees);
}

// the mean of the evaluated neighbours; false unless all exist and are sure of the same class
bool interpolate(const CoarseBody& b, const std::vector<std::int32_t>& place_at,
                 const std::vector<std::uint8_t>& shares, std::array<std::int64_t, 3> at, std::uint8_t* out) {
  std::array<std::uint32_t, voxel_class_count> sums{};
  std::uint32_t count = 0;
  int agreed = -1;
  const Grid& g = b.grid();
  std::array<std::int64_t, 3> low, high;
  for (std::size_t c = 0; c < 3; ++c) low[c] = at[c] - (at[c] & 1), high[c] = at[c] + (at[c] & 1);
  for (std::int64_t k = low[2]; k <= high[2]; k += 2)
    for (std::int64_t j = low[1]; j <= high[1]; j += 2)
      for (std::int64_t i = low[0]; i <= high[0]; i += 2) {
        if (!g.holds(i, j, k)) return false;
        const std::int32_t place = place_at[g.offset(i, j, k)];
        if (place == no_place) return false;
        const std::uint8_t* const there = shares.data() + static_cast<std::size_t>(place) * voxel_class_count;
        const auto best = static_cast<int>(std::max_element(there, there + voxel_class_count) - there);
        if (there[best] < sure || (agreed >= 0 && best != agreed)) return false;
        agreed = best, ++count;
        for (std::size_t c = 0; c < voxel_class_count; ++c) sums[c] += there[c];
      }
  for (std::size_t c = 0; c < voxel_class_count; ++c)
    out[c] = static_cast<std::uint8_t>((sums[c] + count / 2) / count);
  return true;
}

}  // namespace

int voxel_class(int part_label) {
  if (part_label == 0) return -1;
  const std::string_view part = parts[static_cast<std::size_t>(part_label)].name;
  for (std::size_t c = 0; c < voxel_class_count; ++c)
    if (part.starts_with(voxel_classes[c])) return static_cast<int>(c);
  return 1;  // a part of the trunk
}

Result<ClassProbabilities> class_probabilities(const VoxelFeatures& features, const Forest& forest) {
  if (const auto fits = check_fits(forest); !fits) return tl::unexpected(fits.error());
  const CoarseBody& b = features.body();
  const Grid& g = b.grid();
  ClassProbabilities out;
  out.shares.resize(b.places.size() * voxel_class_count);
  std::vector<std::int32_t> place_at(g.count(), no_place);
  for (std::size_t n = 0; n < b.places.size(); ++n) place_at[b.places[n]] = static_cast<std::int32_t>(n);
  const auto index_of = [&](std::size_t place) {
    const auto o = static_cast<std::int64_t>(b.places[place]);
    return std::array<std::int64_t, 3>{o % g.size[0], o / g.size[0] % g.size[1], o / (g.size[0] * g.size[1])};
  };
  const auto even = [](const std::array<std::int64_t, 3>& at) { return ((at[0] | at[1] | at[2]) & 1) == 0; };
  const auto each = [&](const auto& work) {
    in_turns(static_cast<std::int64_t>(b.places.size()), b.threads,
             [&](std::int64_t first, std::int64_t last) {
               for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n)
                 work(n, index_of(n), out.shares.data() + n * voxel_class_count);
             });
  };
  each([&](std::size_t n, const auto& at, std::uint8_t* shares) {
    if (even(at)) evaluate(features, forest, n, shares);
  });
  each([&](std::size_t n, const auto& at, std::uint8_t* shares) {
    if (!even(at) && !interpolate(b, place_at, out.shares, at, shares)) evaluate(features, forest, n, shares);
  });
  return out;
}

}  // namespace borelli
