#include "segmentation/files/dicom_volumes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <string_view>
#include <tuple>

#include "segmentation/files/slice_stack.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using DicomSlices = std::vector<DicomSlice>;

bool look_alike(const DicomSlice& a, const DicomSlice& b) {
  const auto close = [](double x, double y) { return std::abs(x - y) < 1e-3; };
  return a.modality == b.modality && a.rows == b.rows && a.columns == b.columns &&
         (a.along_row - b.along_row).norm() < 2e-3 && (a.along_column - b.along_column).norm() < 2e-3 &&
         close(a.row_spacing, b.row_spacing) && close(a.column_spacing, b.column_spacing);
}

// ---------------------------------------------------------------- copies

// Hash of the first `most` stored bytes of a slice's pixels.
Result<std::size_t> pixel_digest(const DicomSlice& slice, std::uint64_t most) {
  const DicomPixels& p = slice.pixels;
  auto pieces = p.fragments;
  if (pieces.empty()) pieces.emplace_back(p.offset, static_cast<std::uint32_t>(p.bytes));
  DicomBytes file;
  std::string bytes;
  for (const auto& [offset, length] : pieces) {
    const std::size_t start = bytes.size();
    bytes.resize(start + static_cast<std::size_t>(std::min<std::uint64_t>(length, most - start)));
    const auto to = std::as_writable_bytes(std::span(bytes).subspan(start));
    if (const auto read = file.read(slice, offset, to); !read) return tl::unexpected(read.error());
  }
  return std::hash<std::string_view>()(bytes);
}

// Whether two slices of one size hold the same values, however they are stored.
Result<bool> have_same_values(const DicomSlice& a, const DicomSlice& b) {
  const auto count = static_cast<std::size_t>(a.rows) * static_cast<std::size_t>(a.columns);
  std::array<std::vector<std::int32_t>, 2> pixels{std::vector<std::int32_t>(count),
                                                  std::vector<std::int32_t>(count)};
  for (const auto& [slice, to] : {std::pair(&a, &pixels[0]), {&b, &pixels[1]}})
    if (const auto read = read_dicom_pixels(*slice, std::span(*to)); !read)
      return tl::unexpected(read.error());
  const double within = 1e-6 * std::max(std::abs(a.slope), std::abs(b.slope));
  for (std::size_t n = 0; n < count; ++n)
    if (!(std::abs(a.slope * pixels[0][n] + a.intercept - b.slope * pixels[1][n] - b.intercept) <= within))
      return false;
  return true;
}

// Marks copies of an earlier slice among slices at one place along the normal.
Result<std::vector<bool>> copies_among(std::span<const DicomSlice> slices) {
  std::vector<bool> copy(slices.size(), false);
  const auto header = [](const DicomSlice& s) {
    std::uint64_t bytes = s.pixels.bytes;
    for (const auto& fragment : s.pixels.fragments) bytes += fragment.second;
    return std::tuple(bytes, s.slope, s.intercept, s.pixels.bits_allocated, s.pixels.bits_stored,
                      s.pixels.is_signed, s.pixels.packing);
  };
  // Different slices usually differ at their start: only those with equal starts are read completely.
  std::vector<std::size_t> starts, wholes(slices.size(), 0);
  for (const auto& slice : slices) {
    const auto start = pixel_digest(slice, std::uint64_t{1} << 16);
    if (!start) return tl::unexpected(start.error());
    starts.push_back(*start);
  }
  const auto whole = [&](std::size_t n) -> Result<std::size_t> {
    if (wholes[n] == 0) {
      const auto all = pixel_digest(slices[n], ~std::uint64_t{0});
      if (!all) return tl::unexpected(all.error());
      wholes[n] = std::max<std::size_t>(*all, 1);
    }
    return wholes[n];
  };
  for (std::size_t n = 1; n < slices.size(); ++n)
    for (std::size_t m = 0; m < n && !copy[n]; ++m) {
      if (copy[m] || (*slices[m].position - *slices[n].position).norm() > same_place) continue;
      if (header(slices[m]) != header(slices[n])) {  // stored in another way
        const auto same = have_same_values(slices[m], slices[n]);
        if (!same) return tl::unexpected(same.error());
        copy[n] = *same;
        continue;
      }
      if (starts[m] != starts[n]) continue;
      const auto one = whole(m), other = whole(n);
      if (!one) return tl::unexpected(one.error());
      if (!other) return tl::unexpected(other.error());
      copy[n] = *one == *other;
    }
  return copy;
}

// Drops copies and returns their number. Reads pixels only of slices that share a place.
Result<std::size_t> drop_copies(DicomSlices& slices) {
  sort_along(slices);
  const Vector3d normal = slices.front().normal();
  std::vector<std::pair<std::size_t, std::size_t>> places;  // [first, last) of slices at one place
  for (std::size_t first = 0, last = 1; first < slices.size(); first = last++) {
    while (last < slices.size() &&
           normal.dot(*slices[last].position - *slices[last - 1].position) < same_place)
      ++last;
    if (last - first > 1) places.emplace_back(first, last);
  }
  std::vector<Result<std::vector<bool>>> found(places.size());
  in_turns(std::ssize(places), 0, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t n = from; n < to; ++n) {
      const auto [first, last] = places[static_cast<std::size_t>(n)];
      found[static_cast<std::size_t>(n)] = copies_among(std::span(slices).subspan(first, last - first));
    }
  });
  std::vector<bool> copy(slices.size(), false);
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (!found[n]) return tl::unexpected(found[n].error());
    std::copy(found[n]->begin(), found[n]->end(),
              copy.begin() + static_cast<std::ptrdiff_t>(places[n].first));
  }
  DicomSlices once;
  for (std::size_t n = 0; n < slices.size(); ++n)
    if (!copy[n]) once.push_back(std::move(slices[n]));
  const std::size_t dropped = slices.size() - once.size();
  slices = std::move(once);
  return dropped;
}

// ---------------------------------------------------------------- parts of a series

struct SliceExtent {
  double low = 0, high = 0;  // places along the normal, mm
  double length() const { return high - low; }
};
SliceExtent slice_extent(const DicomSlices& slices, const Vector3d& normal) {
  SliceExtent e{normal.dot(*slices.front().position), 0};
  e.high = e.low;
  for (const auto& s : slices) {
    const double at = normal.dot(*s.position);
    e.low = std::min(e.low, at), e.high = std::max(e.high, at);
  }
  return e;
}

bool has_double_places(const DicomSlices& slices) {
  std::vector<double> along;
  const Vector3d normal = slices.front().normal();
  for (const auto& s : slices) along.push_back(normal.dot(*s.position));
  std::ranges::sort(along);
  return std::ranges::adjacent_find(along, [](double a, double b) { return b - a < same_place; }) !=
         along.end();
}

// Joins stations of one body, the largest first: each adds the slices beyond those before it. A part that
// overlaps by half or more of the shorter one images the same place again and stays apart.
std::vector<DicomVolume> join_stations(std::vector<DicomVolume> parts) {
  std::ranges::stable_sort(parts, std::greater<>(), [](const DicomVolume& v) { return v.slices.size(); });
  std::vector<DicomVolume> volumes{std::move(parts.front())};
  DicomVolume& joined = volumes.front();
  const Vector3d normal = joined.slices.front().normal();
  const double half_step = slice_extent(joined.slices, normal).length() /
                           std::max(1.0, 2 * (static_cast<double>(joined.slices.size()) - 1));
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const SliceExtent have = slice_extent(joined.slices, normal), own = slice_extent(parts[n].slices, normal);
    const double overlap = std::min(have.high, own.high) - std::max(have.low, own.low);
    DicomSlices beyond;
    for (const auto& s : parts[n].slices)
      if (const double at = normal.dot(*s.position); at < have.low - half_step || at > have.high + half_step)
        beyond.push_back(s);
    auto all = joined.slices;
    all.insert(all.end(), beyond.begin(), beyond.end());
    if (!(overlap < 0.5 * std::min(have.length(), own.length())) || beyond.empty() || !in_one_line(all)) {
      volumes.push_back(std::move(parts[n]));
      continue;
    }
    if (overlap > 0)
      joined.notes.push_back(fmt::format("{} overlaps {} by {:.4g} mm; the overlap was taken from {}",
                                         parts[n].part, joined.part, overlap, joined.part));
    joined.slices = std::move(all);
    joined.part += " and " + parts[n].part;
  }
  return volumes;
}

struct PartingAttribute {
  std::string DicomSlice::*value;
  const char* name;
};
constexpr std::array<PartingAttribute, 4> parting_attributes{{{&DicomSlice::acquisition, "acquisition"},
                                                              {&DicomSlice::temporal_position, "time"},
                                                              {&DicomSlice::echo, "echo"},
                                                              {&DicomSlice::image_type, "image type"}}};

// Splits a series by the first attribute that leaves no place twice; else keeps it whole.
std::vector<DicomVolume> part_series(DicomSlices once) {
  if (missing_slices(once) == 0) return {{std::move(once), "", {}}};
  const bool doubles = has_double_places(once);
  for (const auto& [value, name] : parting_attributes) {
    std::map<std::string, DicomSlices> by_value;
    for (const auto& s : once) by_value[s.*value].push_back(s);
    if (by_value.size() < 2 ||
        std::ranges::any_of(by_value, [](const auto& v) { return has_double_places(v.second); }))
      continue;
    std::vector<DicomVolume> parted;
    for (auto& [text, slices] : by_value)
      parted.push_back({std::move(slices), fmt::format("{} {}", name, text), {}});
    if (value == &DicomSlice::acquisition) {
      const std::size_t count = parted.size();
      parted = join_stations(std::move(parted));
      // acquisitions that interleave without a double place are one uneven series
      if (!doubles && (parted.size() > 1 || parted.front().notes.empty())) return {{std::move(once), "", {}}};
      if (parted.size() == 1 && count > 1) parted.front().part.clear();
    } else if (!doubles) {
      continue;
    }
    return parted;
  }
  return {{std::move(once), "", {}}};
}

// ---------------------------------------------------------------- series of few slices

// Joins small groups that differ in their series alone: each of one slice, or all together evenly spaced.
Result<void> join_small_series(std::vector<DicomSlices>& groups, std::vector<DicomVolume>& volumes) {
  constexpr std::size_t small = 5;  // slices; a scan of a body has more
  std::vector<std::vector<DicomSlices>> families;
  for (const DicomSlices& group : groups) {
    if (group.size() > small) continue;
    const auto own = std::ranges::find_if(
        families, [&](const auto& family) { return look_alike(family.front().front(), group.front()); });
    own == families.end() ? families.push_back({group}) : own->push_back(group);
  }
  for (const std::vector<DicomSlices>& family : families) {
    if (family.size() < 3) continue;
    DicomSlices slices;
    for (const DicomSlices& group : family) slices.insert(slices.end(), group.begin(), group.end());
    const bool singles = slices.size() == family.size();
    const auto copies = drop_copies(slices);
    if (!copies) return tl::unexpected(copies.error());
    if (slices.size() < 3 || has_double_places(slices) || !in_one_line(slices) ||
        !(singles || missing_slices(slices) == 0))
      continue;
    std::erase_if(groups, [&](const DicomSlices& g) {
      return g.size() <= small && look_alike(g.front(), slices.front());
    });
    DicomVolume volume{std::move(slices), "", {}};
    volume.notes.push_back(
        fmt::format("its slices have {} different series UIDs; they were read as one series", family.size()));
    if (*copies) volume.notes.push_back(fmt::format("{} slices appear twice", *copies));
    volumes.push_back(std::move(volume));
  }
  return {};
}

}  // namespace

bool belong_together(const DicomSlice& a, const DicomSlice& b) {
  return a.series_uid == b.series_uid && look_alike(a, b);
}

Result<std::vector<DicomVolume>> volumes_of(std::vector<DicomSlices> groups) {
  std::vector<DicomVolume> volumes;
  if (const auto joined = join_small_series(groups, volumes); !joined) return tl::unexpected(joined.error());
  for (DicomSlices& group : groups) {
    const auto copies = drop_copies(group);
    if (!copies) return tl::unexpected(copies.error());
    for (DicomVolume& volume : part_series(std::move(group))) {
      if (*copies)
        volume.notes.push_back(
            fmt::format("{} slices appear twice (same position, same values); each was read once", *copies));
      volumes.push_back(std::move(volume));
    }
  }
  return volumes;
}

}  // namespace borelli
