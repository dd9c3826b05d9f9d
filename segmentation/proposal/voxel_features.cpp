#include "segmentation/proposal/voxel_features.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "segmentation/body/tissues.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

constexpr std::array<std::int64_t, 4> cube_radius{1, 3, 7, 15};  // voxels: 12, 28, 60 and 124 mm
constexpr std::int64_t beside_radius = 5;                        // 44 mm
constexpr std::array<std::int64_t, 2> beside_reach{12, 25};      // 48 and 100 mm
constexpr std::array<std::string_view, 3> beside_tissue{"body", "bone", "lung"};
constexpr std::array<std::string_view, 6> beside_name{"up",   "down",         "front",
                                                      "back", "across_least", "across_most"};
constexpr int longest_run = 400;  // mm

std::vector<std::string> make_names() {
  std::vector<std::string> names{"hu"};
  for (const std::int64_t r : cube_radius) {
    const std::string size = std::to_string(4 * (2 * r + 1));
    for (const char* what : {"hu_", "body_", "bone_", "fat_", "lung_"}) names.push_back(what + size);
  }
  for (const std::int64_t reach : beside_reach)
    for (const std::string_view side : beside_name)
      for (const std::string_view tissue : beside_tissue)
        names.push_back(std::string(tissue) + "_" + std::string(side) + "_" + std::to_string(4 * reach));
  for (const char* name : {"depth",
                           "off_bone",
                           "run_up",
                           "run_down",
                           "run_front",
                           "run_back",
                           "run_across_least",
                           "run_across_most",
                           "slice_pieces",
                           "slice_area",
                           "slice_off_middle",
                           "piece_area",
                           "piece_share",
                           "piece_width",
                           "piece_depth",
                           "piece_off_middle",
                           "piece_behind_middle",
                           "piece_bone",
                           "piece_lung",
                           "piece_bones",
                           "off_piece_across",
                           "off_piece_back",
                           "way_from_middle",
                           "way_to_end",
                           "way_to_next_end",
                           "way_to_farthest_end",
                           "section_area",
                           "section_area_before",
                           "section_area_after",
                           "section_bone",
                           "beyond_length",
                           "beyond_volume",
                           "beyond_bone",
                           "beyond_share",
                           "beyond_cut"})
    names.emplace_back(name);
  return names;
}

// part / of in thousandths; -1 if `of` is 0
std::int16_t share(std::int32_t part, std::int32_t of) {
  return of > 0 ? static_cast<std::int16_t>((1000 * static_cast<std::int64_t>(part) + of / 2) / of) : -1;
}

std::int16_t whole(double x) {
  return static_cast<std::int16_t>(std::lround(std::clamp(x, -30000.0, 30000.0)));
}

class Row {
 public:
  explicit Row(std::span<std::int16_t> row) : row_(row) {}
  void put(std::int16_t value) { row_[next_++] = value; }
  void put_whole(double value) { put(whole(value)); }

 private:
  std::span<std::int16_t> row_;
  std::size_t next_ = 0;
};

VoxelBox cube(std::int64_t i, std::int64_t j, std::int64_t k, std::int64_t radius) {
  return {{i - radius, j - radius, k - radius}, {i + radius, j + radius, k + radius}};
}

}  // namespace

const std::vector<std::string>& voxel_feature_names() {
  static const std::vector<std::string> names = make_names();
  return names;
}

VoxelFeatures::VoxelFeatures(const CoarseBody& b)
    : body_(b),
      branches_(body_branches(b)),
      pieces_(slice_pieces(b)),
      seen_(b.grid(), [&](std::size_t o) { return b.seen.voxels[o]; }),
      hu_(b.grid(), [&](std::size_t o) { return b.seen.voxels[o] ? std::min<int>(b.hu.voxels[o], 400) : 0; }),
      flesh_(b.grid(), [&](std::size_t o) { return b.body.voxels[o]; }),
      bone_(b.grid(), [&](std::size_t o) { return b.bone.voxels[o] && b.body.voxels[o]; }),
      fat_(b.grid(),
           [&](std::size_t o) {
             return b.body.voxels[o] && b.hu.voxels[o] < fat_to_hu && b.hu.voxels[o] >= lung_to_hu;
           }),
      lung_(b.grid(), [&](std::size_t o) { return b.body.voxels[o] && b.hu.voxels[o] < lung_to_hu; }) {
  place_.assign(b.grid().count(), 0);
  for (std::size_t n = 0; n < b.places.size(); ++n) place_[b.places[n]] = static_cast<std::uint32_t>(n);
  measure_runs();
}

void VoxelFeatures::measure_runs() {
  runs_.resize(body_.places.size());
  const Grid& g = body_.grid();
  const auto step = static_cast<int>(labelling_step);
  // run length from each voxel towards one end of an axis, by a sweep along it
  const auto sweep = [&](std::int64_t stride, bool ascending, const auto& put) {
    std::vector<std::uint16_t> length(g.count(), 0);
    const auto count = static_cast<std::int64_t>(body_.places.size());
    for (std::int64_t n = 0; n < count; ++n) {
      const auto place = static_cast<std::size_t>(ascending ? n : count - 1 - n);
      const auto o = static_cast<std::int64_t>(body_.places[place]);
      const std::int64_t before = ascending ? o - stride : o + stride;
      // a row's end borders on the next row's start: both are air, unless the scan cuts the body there
      const bool inside = before >= 0 && before < static_cast<std::int64_t>(g.count());
      const int so_far = inside ? length[static_cast<std::size_t>(before)] : 0;
      const auto here = static_cast<std::uint16_t>(std::min(longest_run, so_far + step));
      length[static_cast<std::size_t>(o)] = here;
      put(runs_[place], here);
    }
  };
  const std::int64_t row = g.size[0], slice = g.size[0] * g.size[1];
  sweep(slice, false, [](Runs& r, std::uint16_t l) { r.length[0] = l; });
  sweep(slice, true, [](Runs& r, std::uint16_t l) { r.length[1] = l; });
  sweep(row, true, [](Runs& r, std::uint16_t l) { r.length[2] = l; });
  sweep(row, false, [](Runs& r, std::uint16_t l) { r.length[3] = l; });
  sweep(1, true, [](Runs& r, std::uint16_t l) { r.across_least = r.across_most = l; });
  sweep(1, false, [](Runs& r, std::uint16_t l) {
    r.across_least = std::min(r.across_least, l), r.across_most = std::max(r.across_most, l);
  });
}

void VoxelFeatures::fill(std::size_t o, std::span<std::int16_t> values) const {
  const Grid& g = body_.grid();
  const auto n = static_cast<std::int64_t>(o);
  const std::int64_t i = n % g.size[0], j = n / g.size[0] % g.size[1], k = n / (g.size[0] * g.size[1]);
  Row row(values);
  row.put(body_.hu.voxels[o]);
  for (const std::int64_t r : cube_radius) {
    const VoxelBox box = cube(i, j, k, r);
    const std::int32_t seen = seen_.sum(box), flesh = flesh_.sum(box);
    row.put_whole(static_cast<double>(hu_.sum(box)) / std::max(1, seen));
    row.put(share(flesh, seen));
    row.put(share(bone_.sum(box), flesh));
    row.put(share(fat_.sum(box), flesh));
    row.put(share(lung_.sum(box), flesh));
  }
  for (const std::int64_t reach : beside_reach) {
    const auto beside = [&](std::int64_t di, std::int64_t dj, std::int64_t dk) {
      const VoxelBox box = cube(i + di * reach, j + dj * reach, k + dk * reach, beside_radius);
      const std::int32_t seen = seen_.sum(box), flesh = flesh_.sum(box);
      return std::array<std::int16_t, 3>{share(flesh, seen), share(bone_.sum(box), flesh),
                                         share(lung_.sum(box), flesh)};
    };
    for (const auto& three : {beside(0, 0, 1), beside(0, 0, -1), beside(0, -1, 0), beside(0, 1, 0)})
      for (const std::int16_t value : three) row.put(value);
    const auto left = beside(1, 0, 0), right = beside(-1, 0, 0);
    for (std::size_t t = 0; t < 3; ++t) row.put(std::min(left[t], right[t]));
    for (std::size_t t = 0; t < 3; ++t) row.put(std::max(left[t], right[t]));
  }
  const Runs& runs = runs_[place_[o]];
  row.put(body_.depth[o]);
  row.put(body_.off_bone[o]);
  for (const std::uint16_t length : runs.length) row.put(static_cast<std::int16_t>(length));
  row.put(static_cast<std::int16_t>(runs.across_least));
  row.put(static_cast<std::int16_t>(runs.across_most));

  const auto& slice = pieces_.slices[static_cast<std::size_t>(k)];
  const SlicePiece& piece = pieces_.list[static_cast<std::size_t>(pieces_.number[o])];
  const double x = labelling_step * static_cast<double>(i), y = labelling_step * static_cast<double>(j);
  row.put_whole(std::min(slice.pieces, 8));
  row.put_whole(slice.voxels);
  row.put_whole(std::abs(x - slice.centre_x));
  row.put_whole(piece.voxels);
  row.put(share(piece.voxels, slice.voxels));
  row.put_whole(piece.width);
  row.put_whole(piece.depth);
  row.put_whole(std::abs(piece.centre_x - slice.centre_x));
  row.put_whole(piece.centre_y - slice.centre_y);
  row.put(share(piece.bone, piece.voxels));
  row.put(share(piece.lung, piece.voxels));
  row.put_whole(std::min(piece.bones, 12));
  row.put_whole(std::abs(x - piece.centre_x));
  row.put_whole(y - piece.centre_y);

  row.put_whole(branches_.from_middle[o]);
  row.put_whole(branches_.nearest_end[o]);
  row.put_whole(branches_.next_end[o]);
  row.put_whole(branches_.farthest_end[o]);
  const auto at = [&](std::int32_t s) -> const BodySection& {
    return branches_.sections[static_cast<std::size_t>(s)];
  };
  const BodySection& section = at(branches_.section[o]);
  // sections about 60 mm nearer to the body's centre, and farther from it
  const BodySection *before = &section, *after = &section;
  for (int s = 0; s < 5 && before->parent >= 0; ++s) before = &at(before->parent);
  for (int s = 0; s < 5 && after->main_child >= 0; ++s) after = &at(after->main_child);
  row.put_whole(section.voxels);
  row.put_whole(before->voxels);
  row.put_whole(after->voxels);
  row.put(share(section.bone, section.voxels));
  row.put_whole(band_width * (section.last_band + 1 - section.band));
  row.put_whole(section.voxels_beyond / 16.0);  // approximately cm^3
  row.put(share(section.bone_beyond, section.voxels_beyond));
  row.put(share(section.last_band + 1 - section.band, section.last_band + 1));
  row.put(section.cut ? 1 : 0);
}

}  // namespace borelli
