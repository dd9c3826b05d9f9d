// Reads label maps: numbers become at most 255 labels, names come from a TSV.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>
#include <unordered_map>

#include "error/plain_cell.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/dicom_segmentation.hpp"
#include "segmentation/files/header_text.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/files/mask_folder.hpp"
#include "segmentation/files/plausibility.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/segment_overlaps.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Names = std::map<std::int64_t, std::string>;  // by the number in the file

std::vector<std::string> columns(std::string line) {
  if (line.ends_with('\r')) line.pop_back();
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == '\t') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

Result<Names> read_names(const std::string& path) {
  const auto text = read_input_file(path);
  if (!text) return tl::unexpected(text.error());
  std::istringstream file(*text);
  std::string line;
  std::getline(file, line);
  const auto header = columns(line);
  const auto column = [&](std::string_view name) { return std::ranges::find(header, name) - header.begin(); };
  const auto end = std::ssize(header);
  const auto number_column = std::min(column("label"), column("index")), name_column = column("name");
  if (number_column == end || name_column == end)
    return failure(path + ":1", "expected the header 'label<TAB>name'; found '" + line + "'");

  Names names;
  std::set<std::string> seen;
  for (int row = 2; std::getline(file, line); ++row) {
    const std::string where = path + ":" + std::to_string(row);
    const auto cells = columns(line);
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (std::ssize(cells) <= std::max(number_column, name_column))
      return failure(where, "no tab separates label and name: '" + line + "'");
    const std::string &digits = cells[static_cast<std::size_t>(number_column)],
                      name = text_of_cell(cells[static_cast<std::size_t>(name_column)]);
    if (digits.empty() || digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos)
      return failure(where, "expected a label, a whole number from 0; found '" + digits + "'");
    const std::int64_t value = std::stoll(digits);
    if (name.empty()) return failure(where, "label " + digits + " has no name");
    if (names.contains(value)) return failure(where, "label " + digits + " appears twice");
    if (!seen.insert(name).second) return failure(where, "the name '" + name + "' appears twice");
    names[value] = name;
  }
  return names;
}

// Allowed distance of a label from a whole number: 0.01 for floating point; for scaled integers half a step,
// at most 0.25.
double most_beside_whole(const ImageHeader& header) {
  const bool whole = header.scalar != Scalar::f32 && header.scalar != Scalar::f64;
  return std::max(0.01, whole && header.slope != 1 ? std::min(0.51 * std::abs(header.slope), 0.25) : 0.0);
}

// The numbers that occur. Consecutive equal voxels are looked up once.
Result<std::set<std::int64_t>> label_numbers(const std::string& path, const StoredVoxels& voxels,
                                             const ImageHeader& header, std::vector<std::string>& warnings) {
  std::set<std::int64_t> numbers;
  const double most_beside = most_beside_whole(header);
  double beside = 0, example = 0;
  std::string trouble;
  with_scalar(voxels.scalar, [&]<class T>(T) {
    const std::byte* p = voxels.bytes();
    T before{};
    for (std::size_t n = 0; n < voxels.count && trouble.empty(); ++n, p += sizeof(T)) {
      T stored;
      std::memcpy(&stored, p, sizeof stored);
      if (n > 0 && stored == before) continue;
      before = stored;
      const double value = header.slope * static_cast<double>(stored) + header.intercept;
      const double number = std::round(value);
      if (!(number >= 0 && number <= 1e9) || std::abs(value - number) > most_beside) {
        trouble = "a voxel has the value " + exact(value);
      } else {
        if (std::abs(value - number) > beside) beside = std::abs(value - number), example = value;
        numbers.insert(static_cast<std::int64_t>(number));
        if (numbers.size() > 65536) trouble = "it has more than 65536 different values";
      }
    }
  });
  if (!trouble.empty())
    return failure(path, "is not a label map: " + trouble + "; labels are whole numbers from 0");
  if (beside > 0)
    warnings.push_back("its labels were saved as floating-point or scaled numbers (one is " + exact(example) +
                       ") and were rounded to whole numbers");
  numbers.erase(0);
  return numbers;
}

// The label of each number: parts as in parts.hpp, others from 17 on. Without parts, the number itself.
Result<std::map<std::int64_t, std::uint8_t>> assign_labels(const std::string& path,
                                                           std::set<std::int64_t> numbers, const Names& names,
                                                           bool as_parts) {
  std::size_t count = numbers.size();
  for (const auto& [number, name] : names)
    if (number > 0) numbers.insert(number);
  const bool has_parts =
      as_parts && std::ranges::any_of(names, [](const auto& n) { return part_label(n.second) > 0; });
  const bool keep = !has_parts && !numbers.empty() && *numbers.rbegin() <= 255;

  std::map<std::int64_t, std::uint8_t> labels;
  int next = has_parts ? static_cast<int>(parts.size()) : 1;
  for (const std::int64_t number : numbers) {
    const auto name = names.find(number);
    const int part = !has_parts || name == names.end() ? 0 : part_label(name->second);
    const std::int64_t label = part > 0 ? part : keep ? number : next++;
    if (label > 255)
      return failure(path, "has " + std::to_string(count) + " labels in its voxels and " +
                               std::to_string(numbers.size()) +
                               " together with its named ones; at most 255 are possible");
    labels[number] = static_cast<std::uint8_t>(label);
  }
  return labels;
}

std::vector<std::uint8_t> relabel(const StoredVoxels& voxels, const ImageHeader& header,
                                  const std::map<std::int64_t, std::uint8_t>& labels) {
  std::vector<std::uint8_t> out(voxels.count);
  with_scalar(voxels.scalar, [&]<class T>(T) {
    const std::byte* p = voxels.bytes();
    T before{};
    std::uint8_t label = 0;
    for (std::size_t n = 0; n < voxels.count; ++n, p += sizeof(T)) {
      T stored;
      std::memcpy(&stored, p, sizeof stored);
      if (n == 0 || stored != before) {
        const auto number = std::llround(header.slope * static_cast<double>(stored) + header.intercept);
        label = number == 0 ? std::uint8_t{0} : labels.at(number);
        before = stored;
      }
      out[n] = label;
    }
  });
  return out;
}

}  // namespace

std::string names_file(const std::string& path) {
  const std::filesystem::path whole(path);
  std::filesystem::path stem = whole.filename();
  if (lower_case(stem.extension().string()) == ".gz") stem = stem.stem();
  return (whole.parent_path() / stem.stem()).string() + ".tsv";
}

namespace {

struct Read {
  NumberedLabels labels;
  Names names;
  std::map<std::int64_t, std::vector<std::string>> other_names;  // by number
};

Result<StoredVoxels> stored(const std::vector<std::uint16_t>& numbers) {
  StoredVoxels voxels{Scalar::u16, numbers.size(), std::vector<std::int16_t>(numbers.size())};
  std::memcpy(voxels.storage.data(), numbers.data(), 2 * numbers.size());
  return voxels;
}

// The numbers of a segmentation's segments: their values if these are unique, else 1, 2, ... in their order.
std::vector<std::int64_t> segment_numbers(const ImageHeader& header) {
  std::vector<std::int64_t> numbers;
  std::set<std::int64_t> seen;
  for (const ImageSegment& segment : header.segments) {
    numbers.push_back(segment.value);
    seen.insert(segment.value);
  }
  if (seen.size() < numbers.size()) std::iota(numbers.begin(), numbers.end(), std::int64_t{1});
  return numbers;
}

// Merges layers. `overlaps` knows the segments, numbered from 1 in their order.
StoredVoxels flatten(const StoredVoxels& stored, ImageHeader& header,
                     const std::vector<std::int64_t>& numbers, SegmentOverlaps& overlaps) {
  const auto layers = static_cast<std::size_t>(header.layers), count = header.grid.count();
  StoredVoxels flat{Scalar::i32, count, std::vector<std::int16_t>(2 * count, 0)};
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> segment_of;  // by layer and value
  for (std::size_t n = 0; n < header.segments.size(); ++n)
    segment_of[{header.segments[n].layer, header.segments[n].value}] = n;
  with_scalar(stored.scalar, [&]<class T>(T) {
    for (std::size_t o = 0; o < count; ++o) {
      std::int64_t top = 0;
      for (std::size_t layer = 0; layer < layers; ++layer) {
        T value;
        const std::size_t at = header.layers_interleaved ? o * layers + layer : layer * count + o;
        std::memcpy(&value, stored.bytes() + at * sizeof(T), sizeof value);
        const double number = std::round(static_cast<double>(value));
        if (!(number >= 1 && number <= 1e9)) continue;
        const auto it =
            segment_of.find({static_cast<std::int64_t>(layer), static_cast<std::int64_t>(number)});
        if (it != segment_of.end()) top = overlaps.winner(top, static_cast<std::int64_t>(it->second) + 1);
      }
      const auto number = top > 0 ? static_cast<std::int32_t>(numbers[static_cast<std::size_t>(top) - 1]) : 0;
      std::memcpy(reinterpret_cast<std::byte*>(flat.storage.data()) + o * sizeof number, &number,
                  sizeof number);
    }
  });
  header.slope = 1, header.intercept = 0;
  return flat;
}

Result<void> check_lattice(const std::string& path, const Grid& labels, const Grid* scan) {
  if (!scan || same_lattice(labels, *scan)) return {};
  const auto words = [](const Grid& grid) {
    const Eigen::Vector3d spacing = grid.spacing();
    return fmt::format("{} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} mm", grid.size[0], grid.size[1],
                       grid.size[2], spacing[0], spacing[1], spacing[2]);
  };
  return bad_use(path,
                 fmt::format("lies on another grid ({}) than the scan ({}); resample one onto the other",
                             words(labels), words(*scan)));
}

// Takes a segment's names. If parts are wanted and its name is not a part's, a code or ID that is a part's
// replaces it.
void take_names(const ImageSegment& segment, std::int64_t number, bool as_parts, Read& out) {
  std::string name = segment.name;
  if (as_parts && part_label(name) == 0)
    for (const std::string& other : segment.other_names)
      if (part_label(other) > 0) {
        name = other;
        break;
      }
  if (name.empty() && !segment.other_names.empty()) name = segment.other_names.front();
  if (!name.empty()) out.names[number] = name;
  if (!segment.other_names.empty()) out.other_names[number] = segment.other_names;
}

// Makes the label map of the stored numbers. `labels`: of each number.
void fill_labels(const StoredVoxels& voxels, ImageHeader& header,
                 const std::map<std::int64_t, std::uint8_t>& labels, Read& out) {
  LabelMap& map = out.labels.map;
  map.grid = header.grid;
  map.voxels = relabel(voxels, header, labels);
  map.names = {"outside"};
  map.warnings = std::move(header.warnings);
  if (auto doubt = doubt_of_size(map.grid); !doubt.empty()) map.warnings.push_back(std::move(doubt));
  out.labels.numbers = {0};
  for (const auto& [number, label] : labels) {
    if (map.names.size() <= label) map.names.resize(label + std::size_t{1});
    if (out.labels.numbers.size() <= label) out.labels.numbers.resize(label + std::size_t{1});
    const auto name = out.names.find(number);
    if (name != out.names.end()) map.names[label] = name->second;
    out.labels.numbers[label] = number;
    if (const auto others = out.other_names.find(number); others != out.other_names.end())
      out.labels.other_names[label] = others->second;
  }
}

// Takes the segments of a file, and merges their layers.
Result<void> take_segments(const std::string& path, bool named_by_table, bool as_parts, const IsUsed& is_used,
                           ImageHeader& header, StoredVoxels& voxels, Read& out) {
  const auto numbers = segment_numbers(header);
  SegmentOverlaps overlaps;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    if (!named_by_table) take_names(header.segments[n], numbers[n], as_parts, out);
    const auto name = out.names.find(numbers[n]);
    const std::string own = name == out.names.end() ? "" : name->second;
    overlaps.add(static_cast<std::int64_t>(n) + 1, own,
                 is_used && is_used(numbers[n], own, header.segments[n].other_names));
  }
  if (header.layers > 1) voxels = flatten(voxels, header, numbers, overlaps);
  auto told = overlaps.warnings(path);
  if (!told) return tl::unexpected(told.error());
  header.warnings.insert(header.warnings.end(), told->begin(), told->end());
  for (const auto segment : overlaps.emptied())
    out.names.erase(numbers[static_cast<std::size_t>(segment) - 1]);
  return {};
}

bool is_part(std::int64_t, const std::string& name, const std::vector<std::string>&) {
  return part_label(name) > 0;
}

Result<Read> read_file(const std::string& path, const std::string& names, const Progress& progress,
                       bool as_parts, const IsUsed& is_used, const Grid* scan = nullptr) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(path, ignored);
  const bool of_masks = is_folder && !masks_in(path).empty();
  const bool of_dicom = !of_masks && (is_folder || is_dicom_file(path));
  if (of_masks && !names.empty())
    return bad_use(
        names,
        "does not apply to a folder of masks, where the file names are the names; leave out --label-names");
  Read out;
  std::string table = names;
  // (a table beside DICOM or masks is another file's)
  if (table.empty() && !of_masks && !of_dicom && std::filesystem::exists(names_file(path), ignored))
    table = names_file(path);
  if (!table.empty()) {
    auto read = read_names(table);
    if (!read) return tl::unexpected(read.error());
    out.names = std::move(*read);
  }

  Result<ImageHeader> header;
  std::optional<DicomSegmentation> dicom;
  std::optional<MaskFolder> masks;
  const auto accept = [&](const Grid& grid) { return check_lattice(path, grid, scan); };
  if (of_masks) {
    auto read = read_mask_folder(path, accept, is_used, progress);
    if (!read) return tl::unexpected(read.error());
    masks = std::move(*read);
    header->grid = masks->grid, header->scalar = Scalar::u8, header->warnings = std::move(masks->warnings);
    out.names = masks->names;
  } else if (of_dicom) {
    auto read = read_dicom_segmentation(path, accept, is_used, table.empty() ? nullptr : &out.names);
    if (!read) return tl::unexpected(read.error());
    dicom = std::move(*read);
    header->grid = dicom->grid, header->scalar = Scalar::u16, header->warnings = std::move(dicom->warnings);
    out.names = dicom->names, out.other_names = dicom->other_names;
  } else {
    header = read_image_header(path);
  }
  if (!header) return tl::unexpected(header.error());
  if (auto fine = check_lattice(path, header->grid, scan); !fine) return tl::unexpected(fine.error());

  auto voxels = masks   ? Result<StoredVoxels>(std::move(masks->voxels))
                : dicom ? stored(dicom->numbers)
                        : load_voxels(*header, progress);
  if (!voxels) return tl::unexpected(voxels.error());
  std::ranges::move(voxels->warnings, std::back_inserter(header->warnings));
  const double bytes_a_voxel = header->layers > 1 ? 5 : 1;
  if (auto fits =
          admit_memory(path, "its label map", bytes_a_voxel * static_cast<double>(header->grid.count()));
      !fits)
    return tl::unexpected(fits.error());
  if (!header->segments.empty())
    if (auto taken = take_segments(path, !table.empty(), as_parts, is_used, *header, *voxels, out); !taken)
      return tl::unexpected(taken.error());
  const auto numbers = label_numbers(path, *voxels, *header, header->warnings);
  if (!numbers) return tl::unexpected(numbers.error());
  const auto labels = assign_labels(path, *numbers, out.names, as_parts);
  if (!labels) return tl::unexpected(labels.error());

  fill_labels(*voxels, *header, *labels, out);
  return out;
}

}  // namespace

namespace {

// One sentence about the numbers that have voxels and no name, in a map that has names; else "".
std::string numbers_without_name(const NumberedLabels& labels) {
  constexpr std::size_t most = 8;
  const auto& names = labels.map.names;
  std::array<std::size_t, 256> voxels{};
  for (const auto label : labels.map.voxels) ++voxels[label];
  std::string list;
  std::size_t unnamed = 0, named = 0;
  for (std::size_t label = 1; label < names.size(); ++label) {
    named += !names[label].empty();
    if (!names[label].empty() || voxels[label] == 0 || ++unnamed > most) continue;
    list += fmt::format("{}{} ({} voxels)", list.empty() ? "" : ", ", labels.numbers[label], voxels[label]);
  }
  if (named == 0 || unnamed == 0) return "";
  if (unnamed > most) list += fmt::format(" and {} more", unnamed - most);
  return "its names lack numbers that its voxels have: " + list;
}

// Whether the map was cropped to its labels, as 3D Slicer saves it: they touch all six faces. Such an edge
// cuts no label.
bool is_cropped(const LabelMap& map) {
  IndexBox box{map.grid.size, {-1, -1, -1}};
  for (std::int64_t k = 0; k < map.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < map.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < map.grid.size[0]; ++i)
        if (map.at(i, j, k))
          for (const auto& [c, n] : {std::pair{std::size_t{0}, i}, {1, j}, {2, k}})
            box.first[c] = std::min(box.first[c], n), box.last[c] = std::max(box.last[c], n);
  for (std::size_t c = 0; c < 3; ++c)
    if (box.first[c] > 0 || box.last[c] + 1 < map.grid.size[c]) return false;
  return true;
}

// The voxels of `scan` that a grid of the same lattice covers; none if these are all.
std::optional<IndexBox> covered_box(const Grid& labels, const Grid& scan) {
  const Eigen::Vector3d a = scan.index(labels.origin),
                        b = scan.index(
                            labels.point(labels.size[0] - 1, labels.size[1] - 1, labels.size[2] - 1));
  IndexBox box;
  bool all = true;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto n = static_cast<Eigen::Index>(c);
    const auto [low, high] = std::minmax({std::lround(a[n]), std::lround(b[n])});
    box.first[c] = std::max<std::int64_t>(low, 0),
    box.last[c] = std::min<std::int64_t>(high, scan.size[c] - 1);
    all = all && low <= 0 && high >= scan.size[c] - 1;
  }
  return all ? std::nullopt : std::optional(box);
}

}  // namespace

Result<LabelMap> read_labels(const std::string& path, const std::string& names, const Progress& progress,
                             const Grid* scan) {
  auto read = read_file(path, names, progress, true, is_part, scan);
  if (!read) return tl::unexpected(read.error());
  LabelMap& map = read->labels.map;
  if (auto told = numbers_without_name(read->labels); !told.empty()) map.warnings.push_back(std::move(told));
  for (std::size_t label = 1; label < map.names.size(); ++label)
    if (const auto number = read->labels.numbers[label]; map.names[label].empty() && number > 0)
      map.names[label] = "label " + std::to_string(number);
  if (!scan || same_grid(map.grid, *scan)) return std::move(map);
  if (auto fits = admit_memory(path, "its label map on the scan's grid", static_cast<double>(scan->count()));
      !fits)
    return tl::unexpected(fits.error());
  LabelMap placed = labels_on(map, *scan);
  placed.warnings = std::move(map.warnings);
  if (!is_cropped(map)) placed.labelled = covered_box(map.grid, *scan);
  const auto beyond = labels_beyond(map, *scan);
  for (const auto& [label, share] : beyond) placed.beyond.insert(label);
  if (auto said = in_words(beyond, map); !said.empty()) placed.warnings.push_back(std::move(said));
  if (const Eigen::Matrix3d turn = scan->axes.inverse() * map.grid.axes; !turn.isIdentity(0.5))
    placed.warnings.push_back(
        "its axes have another order or direction than the scan's, so its voxels were reordered to match the "
        "scan");
  return placed;
}

Result<NumberedLabels> read_numbered_labels(const std::string& path, const std::string& names,
                                            const Progress& progress, const IsUsed& is_used) {
  auto read = read_file(path, names, progress, false, is_used);
  if (!read) return tl::unexpected(read.error());
  return std::move(read->labels);
}

}  // namespace borelli
