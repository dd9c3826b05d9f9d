#include "segmentation/files/dicom_segmentation.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include "process/memory.hpp"
#include "segmentation/files/dicom_elements.hpp"
#include "segmentation/files/dicom_files.hpp"
#include "segmentation/files/dicom_slice.hpp"
#include "segmentation/files/plausibility.hpp"
#include "segmentation/files/terminology.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Frame {
  DicomSlice slice;
  std::int64_t segment = 0;
  std::int64_t k = 0;
};

const DicomItem* macro(const DicomElements& elements, std::size_t frame, std::uint32_t tag) {
  const auto groups = elements.sequences.find(0x52009230);
  if (groups != elements.sequences.end() && frame < groups->second.size())
    if (const DicomItem* own = groups->second[frame].item(tag)) return own;
  const DicomItem* shared = elements.item(0x52009229);
  return shared ? shared->item(tag) : nullptr;
}

// Segmented Property Type and Anatomic Region with their modifiers (C.8.20.4)
SegmentTerms terms_of(const DicomItem& segment) {
  const auto term = [](const DicomItem* item) {
    return item ? CodedTerm{item->text(0x00080102), item->text(0x00080100), item->text(0x00080104)}
                : CodedTerm{};
  };
  const DicomItem *type = segment.item(0x0062000f), *region = segment.item(0x00082218);
  return {term(type), term(type ? type->item(0x00620011) : nullptr), term(region),
          term(region ? region->item(0x00082220) : nullptr)};
}

// the file itself, or the one segmentation in a folder
Result<std::string> file_of(const std::string& path) {
  std::error_code trouble;
  if (!std::filesystem::is_directory(path, trouble)) return path;
  auto below = files_below(path);
  if (!below) return tl::unexpected(below.error());
  std::string found;
  for (const std::string& file : below->files) {
    const auto elements = read_dicom_elements(file);
    if ((!elements || !*elements) && below->placeholders.add_if_placeholder(file)) continue;
    if (!elements || !*elements || (*elements)->text(0x00080060) != "SEG") continue;
    if (!found.empty()) return bad_use(path, "contains several DICOM segmentations; name one of their files");
    found = file;
  }
  if (!found.empty()) return found;
  std::string what =
      "is a folder without a DICOM segmentation; give a label map file or a folder with a segmentation";
  for (const auto& sentence : below->placeholders.sentences()) what += "; " + sentence;
  return bad_use(path, what);
}

// The grid that all frames lie on; sets each frame's slice index. `between`: slice spacing, mm; 0: not given.
Result<Grid> grid_of(const std::string& path, std::vector<Frame>& frames, double between, double thickness) {
  const DicomSlice& first = frames.front().slice;
  const Vector3d normal = first.normal();
  std::vector<double> along;
  for (const Frame& frame : frames) along.push_back(normal.dot(*frame.slice.position));
  const auto [low, high] = std::ranges::minmax_element(along);
  const Vector3d start = *frames[static_cast<std::size_t>(low - along.begin())].slice.position,
                 end = *frames[static_cast<std::size_t>(high - along.begin())].slice.position;
  const double base = *low, total = *high - *low;
  double step = between;
  if (!(step > 0)) {
    auto sorted = along;
    std::ranges::sort(sorted);
    for (std::size_t n = 1; n < sorted.size(); ++n)
      if (const double gap = sorted[n] - sorted[n - 1]; gap > 1e-3 && !(step > 0 && step <= gap)) step = gap;
  }
  if (!(step > 0)) step = thickness;
  if (!(step > 0)) return failure(path, "has all frames at one position and does not state their thickness");
  if (total > longest_scan)
    return failure(
        path,
        fmt::format("has frames that span {:.4g} mm, more than any body; its header is damaged", total));
  const double count = std::round(total / step);
  if (count > 20000)
    return failure(path, "has frames that span far more than their spacing allows; its header is damaged");
  const Vector3d direction = total > 0 ? Vector3d((end - start) / total) : normal;
  if (count > 0) step = total / count;
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const double at = (along[n] - base) / step;
    frames[n].k = std::lround(at);
    const Vector3d off =
        *frames[n].slice.position - start - static_cast<double>(frames[n].k) * step * direction;
    if (off.norm() > std::max(0.06, 0.05 * step))
      return failure(
          path,
          fmt::format("has frames that are not evenly spaced along one line (frame {} is {:.3g} mm off)",
                      n + 1, off.norm()));
    if ((frames[n].slice.along_row - first.along_row).norm() > 2e-3 ||
        (frames[n].slice.along_column - first.along_column).norm() > 2e-3 ||
        std::abs(frames[n].slice.row_spacing - first.row_spacing) > 1e-3)
      return failure(path, "has frames with different orientations or pixel sizes");
  }
  Grid grid;
  grid.size = {first.columns, first.rows, static_cast<std::int64_t>(count) + 1};
  grid.axes << first.column_spacing * first.along_row, first.row_spacing * first.along_column,
      step * direction;
  grid.origin = start;
  return grid;
}

// Reads a frame's bits. Frames follow each other without gaps, the least significant bit of a byte first
// (PS3.5, 8.1.1).
Result<void> read_bits(const DicomSlice& slice, const DicomElements& elements, std::size_t frame,
                       DicomBytes& file, std::span<std::int32_t> values) {
  const std::uint64_t first = frame * values.size(), last = first + values.size();
  std::vector<std::byte> bytes((last + 7) / 8 - first / 8);
  if (const auto read = file.read(slice, elements.pixel_offset + first / 8, bytes); !read) return read;
  for (std::size_t n = 0; n < values.size(); ++n) {
    const std::uint64_t bit = first % 8 + n;
    values[n] = static_cast<std::int32_t>(std::to_integer<unsigned>(bytes[bit / 8]) >> (bit % 8) & 1U);
  }
  return {};
}

// The checked header of a segmentation.
struct SegmentationHeader {
  std::string path;
  DicomElements elements;
  std::string type;
  std::vector<Frame> frames;
  Grid grid;

  bool binary() const { return type == "BINARY"; }
  bool labels() const { return type == "LABELMAP"; }
};

Result<SegmentationHeader> read_segmentation_header(const std::string& path) {
  const auto file = file_of(path);
  if (!file) return tl::unexpected(file.error());
  auto read = read_dicom_elements(*file);
  if (!read) return tl::unexpected(read.error());
  if (!*read || (*read)->text(0x00080060) != "SEG" || (*read)->pixel_offset == 0)
    return bad_use(*file, "is not a DICOM segmentation (modality SEG)");
  SegmentationHeader header{*file, std::move(**read), "", {}, {}};
  const DicomElements& elements = header.elements;
  const auto slices = read_dicom_slices(*file);
  if (!slices) return tl::unexpected(slices.error());
  header.type = elements.text(0x00620001);
  if (!header.binary() && !header.labels() && header.type != "FRACTIONAL")
    return failure(*file, "is a segmentation of the unsupported type '" + header.type +
                              "'; expected BINARY, FRACTIONAL or LABELMAP");

  for (std::size_t n = 0; n < slices->size(); ++n) {
    Frame frame{(*slices)[n]};
    const DicomItem* segment = macro(elements, n, 0x0062000a);
    frame.segment = segment ? segment->number(0x0062000b).value_or(0) : 0;
    if (!frame.slice.position || (!header.labels() && frame.segment == 0))
      return failure(*file, fmt::format("does not state {} of frame {}",
                                        frame.slice.position ? "the segment" : "the position", n + 1));
    if (const auto whole = header.binary() ? Result<void>() : check_pixels(frame.slice); !whole)
      return tl::unexpected(whole.error());
    header.frames.push_back(std::move(frame));
  }
  if (header.frames.empty()) return failure(*file, "is a segmentation without frames");
  if (header.binary() && elements.packed)
    return failure(*file, "has compressed binary frames; decompress it first (gdcmconv --raw)");
  const DicomSlice& first = header.frames.front().slice;
  const double bits = double(header.frames.size()) * first.rows * first.columns;
  if (header.binary() && bits > 8 * double(elements.pixel_bytes))
    return failure(*file, "is cut off or damaged: it has fewer bits than its frames need");
  const DicomItem* measures = macro(elements, 0, 0x00289110);
  const auto said = [&](std::uint32_t tag) {
    const auto list = measures ? measures->decimals(tag) : std::vector<double>{};
    return list.empty() ? 0.0 : list[0];
  };
  const auto grid = grid_of(*file, header.frames, said(0x00180088), said(0x00180050));
  if (!grid) return tl::unexpected(grid.error());
  header.grid = *grid;
  return header;
}

}  // namespace

bool is_dicom_file(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  const auto elements = read_dicom_elements(path);
  return elements && *elements;
}

Result<DicomSegmentation> read_dicom_segmentation(const std::string& path,
                                                  const std::function<Result<void>(const Grid&)>& accept,
                                                  const IsUsed& is_used,
                                                  const std::map<std::int64_t, std::string>* names) try {
  const auto header = read_segmentation_header(path);
  if (!header) return tl::unexpected(header.error());
  DicomSegmentation out;
  SegmentOverlaps overlaps;
  if (accept)
    if (auto fine = accept(header->grid); !fine) return tl::unexpected(fine.error());
  out.grid = header->grid;
  const DicomElements& elements = header->elements;
  if (names) out.names = *names;
  if (const auto list = elements.sequences.find(0x00620002); !names && list != elements.sequences.end())
    for (const DicomItem& segment : list->second)
      if (const auto number = segment.number(0x00620004)) {
        out.names[*number] = segment.text(0x00620005);
        auto others = other_forms(out.names[*number]);
        if (auto coded = class_of_terms(terms_of(segment)); !coded.empty())
          others.push_back(std::move(coded));
        if (!others.empty()) out.other_names[*number] = std::move(others);
      }
  for (const auto& [number, name] : out.names) {
    const auto others = out.other_names.find(number);
    const std::vector<std::string> none;
    overlaps.add(number, name,
                 is_used && is_used(number, name, others == out.other_names.end() ? none : others->second));
  }

  const bool binary = header->binary(), labels = header->labels();
  const std::size_t area = static_cast<std::size_t>(out.grid.size[0] * out.grid.size[1]);
  constexpr std::size_t at_once = 16;  // frames
  const double bytes = static_cast<double>(out.grid.count()) * (binary || labels ? 5 : 9) +
                       4.0 * static_cast<double>(at_once * area);
  if (const auto fits = admit_memory(
          header->path,
          fmt::format("its grid ({} x {} x {})", out.grid.size[0], out.grid.size[1], out.grid.size[2]),
          bytes);
      !fits)
    return tl::unexpected(fits.error());
  const double most = binary ? 1 : elements.number(0x0062000e).value_or(255);
  out.numbers.assign(out.grid.count(), 0);
  std::vector<float> best(binary || labels ? 0 : out.numbers.size(), 0);
  std::vector<std::int32_t> values(std::min(at_once, header->frames.size()) * area);
  const auto claimed = [&](std::uint16_t held, std::uint16_t number) {
    return static_cast<std::uint16_t>(overlaps.winner(held, number));
  };
  DicomBytes file;
  for (std::size_t n = 0; n < header->frames.size(); ++n) {
    const Frame& frame = header->frames[n];
    const auto own = std::span(values).subspan(n % at_once * area, area);
    if (binary) {
      if (const auto read = read_bits(frame.slice, elements, n, file, own); !read)
        return tl::unexpected(read.error());
    } else if (n % at_once == 0) {
      std::vector<DicomSlice> some;
      for (std::size_t m = n; m < std::min(n + at_once, header->frames.size()); ++m)
        some.push_back(header->frames[m].slice);
      const auto read =
          read_dicom_pixels(std::span<const DicomSlice>(some), std::span(values).first(some.size() * area));
      if (!read) return tl::unexpected(read.error());
    }
    const std::size_t at = static_cast<std::size_t>(frame.k) * area;
    const auto number = static_cast<std::uint16_t>(frame.segment);
    for (std::size_t o = 0; o < area; ++o) {
      const std::int32_t value = own[o];
      std::uint16_t& own_number = out.numbers[at + o];
      if (labels) {
        if (value < 0 || value > 65535)
          return failure(header->path,
                         fmt::format("contains the segment number {}; expected 0 to 65535", value));
        if (value != 0) own_number = static_cast<std::uint16_t>(value);
      } else if (binary) {
        if (value != 0) own_number = claimed(own_number, number);
      } else if (const auto share = static_cast<float>(value / most); share >= 0.5F) {
        float& largest = best[at + o];
        if (own_number == 0 || share == largest || overlaps.used(own_number) != overlaps.used(number))
          own_number = claimed(own_number, number);
        else if (share > largest)
          own_number = claimed(0, number);
        if (own_number == number) largest = share;
      }
    }
  }
  auto told = overlaps.warnings(header->path);
  if (!told) return tl::unexpected(told.error());
  out.warnings = std::move(*told);
  for (const auto number : overlaps.emptied()) out.names.erase(number);
  return out;
} catch (const std::bad_alloc&) {
  return failure(path, "contains a segmentation that does not fit into memory; allow more with --max-memory");
}

std::string doubt_of_frames(const std::string& scan, const std::string& labels) {
  namespace fs = std::filesystem;
  const auto frames_of = [](const std::string& path) {
    std::set<std::string> frames;
    const auto add = [&](const fs::path& file) {
      std::error_code ignored;
      if (!fs::is_regular_file(file, ignored)) return;
      if (const auto elements = read_dicom_elements(file.string()); elements && *elements)
        if (const std::string uid = (*elements)->text(0x00200052); !uid.empty()) frames.insert(uid);
    };
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) add(path);
    for (const auto& entry : fs::directory_iterator(path, ignored)) add(entry.path());
    return frames;
  };
  const auto theirs = frames_of(labels);
  if (theirs.empty()) return "";
  const auto ours = frames_of(scan);
  if (ours.empty() || std::ranges::any_of(theirs, [&](const auto& uid) { return ours.contains(uid); }))
    return "";
  return labels +
         ": its frame of reference differs from the scan's, so it may belong to another scan; it was placed "
         "by its coordinates";
}

}  // namespace borelli
