// NRRD, attached (.nrrd) or detached (.nhdr) header, in one file or a list of slices; raw, text, gzip or
// bzip2.
//
// After "Definition of NRRD File Format", teem.sourceforge.net/nrrd/format.html.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <numeric>
#include <optional>

#include "error/printable.hpp"
#include "segmentation/files/header_text.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/files/slice_files.hpp"
#include "segmentation/files/terminology.hpp"
#include "segmentation/files/voxel_size.hpp"

namespace borelli {
namespace {

// more than any file has; the byte count still fits into 64 bits
constexpr double most_voxels = 1e17;

using Eigen::Matrix3d;
using Eigen::Vector3d;

using FieldMap = std::map<std::string, std::string, std::less<>>;

struct Nrrd {
  FieldMap fields;                 // "<field>: <description>", field in lower case
  FieldMap keys;                   // "<key>:=<value>"
  std::vector<std::string> names;  // file names, one per line after "data file: LIST"
  std::uint64_t header_bytes = 0;

  std::string_view data_file() const {
    return field("data file").empty() ? field("datafile") : field("data file");
  }
  std::string_view field(std::string_view name) const {
    const auto it = fields.find(name);
    return it == fields.end() ? std::string_view{} : std::string_view(it->second);
  }
};

Result<Nrrd> parse_nrrd(const std::string& path) {
  const auto text = read_header_text(path, [](std::string_view line) { return line.empty(); });
  if (!text) return tl::unexpected(text.error());
  if (text->lines.empty() || !text->lines.front().starts_with("NRRD"))
    return failure(path, "is not a NRRD file: it does not start with 'NRRD'");
  Nrrd nrrd;
  nrrd.header_bytes = text->end;
  for (const std::string& line : text->lines) {
    if (names_follow(nrrd.data_file())) {
      nrrd.names.push_back(line);
      continue;
    }
    if (line.starts_with('#')) continue;
    if (const auto key = line.find(":="); key != std::string::npos) {
      nrrd.keys[line.substr(0, key)] = line.substr(key + 2);
    } else if (const auto colon = line.find(": "); colon != std::string::npos) {
      const std::string field = lower_case(line.substr(0, colon));
      if (!nrrd.fields.try_emplace(field, trimmed(std::string_view(line).substr(colon + 2))).second)
        return failure(path, "has a damaged header: '" + printable(field) + "' appears twice");
    }
  }
  return nrrd;
}

std::optional<Scalar> nrrd_scalar(std::string_view type) {
  static const std::map<std::string_view, Scalar> types{{"signed char", Scalar::i8},
                                                        {"int8", Scalar::i8},
                                                        {"int8_t", Scalar::i8},
                                                        {"uchar", Scalar::u8},
                                                        {"unsigned char", Scalar::u8},
                                                        {"uint8", Scalar::u8},
                                                        {"uint8_t", Scalar::u8},
                                                        {"short", Scalar::i16},
                                                        {"short int", Scalar::i16},
                                                        {"signed short", Scalar::i16},
                                                        {"signed short int", Scalar::i16},
                                                        {"int16", Scalar::i16},
                                                        {"int16_t", Scalar::i16},
                                                        {"ushort", Scalar::u16},
                                                        {"unsigned short", Scalar::u16},
                                                        {"unsigned short int", Scalar::u16},
                                                        {"uint16", Scalar::u16},
                                                        {"uint16_t", Scalar::u16},
                                                        {"int", Scalar::i32},
                                                        {"signed int", Scalar::i32},
                                                        {"int32", Scalar::i32},
                                                        {"int32_t", Scalar::i32},
                                                        {"uint", Scalar::u32},
                                                        {"unsigned int", Scalar::u32},
                                                        {"uint32", Scalar::u32},
                                                        {"uint32_t", Scalar::u32},
                                                        {"longlong", Scalar::i64},
                                                        {"long long", Scalar::i64},
                                                        {"long long int", Scalar::i64},
                                                        {"signed long long", Scalar::i64},
                                                        {"signed long long int", Scalar::i64},
                                                        {"int64", Scalar::i64},
                                                        {"int64_t", Scalar::i64},
                                                        {"ulonglong", Scalar::u64},
                                                        {"unsigned long long", Scalar::u64},
                                                        {"unsigned long long int", Scalar::u64},
                                                        {"uint64", Scalar::u64},
                                                        {"uint64_t", Scalar::u64},
                                                        {"float", Scalar::f32},
                                                        {"double", Scalar::f64}};
  const auto it = types.find(type);
  if (it == types.end()) return std::nullopt;
  return it->second;
}

// a segment's other names: a person may rename it, but its code and ID stay
std::vector<std::string> other_names_of(std::string_view name, std::string_view id, std::string_view tags) {
  std::vector<std::string> names = other_forms(name);
  if (auto coded = class_of_terms(terms_in_tags(tags)); !coded.empty()) names.push_back(std::move(coded));
  if (!id.empty()) names.emplace_back(id);
  return names;
}

// "Segment0_Name" and so on; empty if the file lacks it
std::string_view segment_key(const Nrrd& nrrd, int segment, const char* what) {
  const auto it = nrrd.keys.find(fmt::format("Segment{}_{}", segment, what));
  return it == nrrd.keys.end() ? std::string_view{} : trimmed(it->second);
}

bool has_segment(const Nrrd& nrrd, int segment) {
  return std::ranges::any_of(std::array{"ID", "Name", "LabelValue"},
                             [&](const char* what) { return !segment_key(nrrd, segment, what).empty(); });
}

// 3D Slicer's segments (.seg.nrrd): "Segment0_Name", "Segment0_LabelValue", "Segment0_Layer",
// "Segment0_ID", "Segment0_Tags" and so on
// (slicer.readthedocs.io, developer guide, Segmentations)
Result<std::vector<ImageSegment>> segments_of(const std::string& path, const Nrrd& nrrd,
                                              std::int64_t layers) {
  std::vector<ImageSegment> segments;
  for (int n = 0;; ++n) {
    if (!has_segment(nrrd, n)) return segments;
    const auto key = [&](const char* what) { return segment_key(nrrd, n, what); };
    // older versions without these keys store one segment per layer, with value 1
    const auto value = number_in(key("LabelValue")), layer = number_in(key("Layer"));
    ImageSegment segment{std::string(key("Name")), value ? whole_number(*value) : 1,
                         layer ? whole_number(*layer) : std::min<std::int64_t>(n, layers - 1),
                         other_names_of(key("Name"), key("ID"), key("Tags"))};
    if (segment.value < 1 || segment.layer < 0 || segment.layer >= layers)
      return failure(
          path, fmt::format("has a damaged header: segment {} ('{}') is value {} of layer {}, of {} layers",
                            n, printable(segment.name), segment.value, segment.layer, layers));
    segments.push_back(std::move(segment));
  }
}

// the layer axis among four axes of a file that names segments: the first or the last
std::optional<std::size_t> layer_axis(const Nrrd& nrrd, const std::vector<double>& sizes) {
  if (sizes.size() != 4 || !has_segment(nrrd, 0)) return std::nullopt;
  const std::string_view kinds = trimmed(nrrd.field("kinds"));
  if (kinds.starts_with("list") || kinds.starts_with("vector")) return 0;
  if (kinds.ends_with("list") || kinds.ends_with("vector")) return 3;
  return std::nullopt;
}

// the file's three spatial axes; other axes of one sample are ignored
Result<std::vector<std::size_t>> volume_axes(const std::string& path, const std::vector<double>& sizes,
                                             std::string_view kinds, std::optional<std::size_t> layers) {
  for (const double size : sizes)
    if (!(size >= 1 && size <= 100000) || size != std::floor(size))
      return failure(path, fmt::format("has a damaged header: an axis has {} voxels", size));
  const double all = std::accumulate(sizes.begin(), sizes.end(), 1.0, std::multiplies<>());
  if (all > most_voxels)
    return failure(path,
                   fmt::format("has a damaged header: it states {:.3g} voxels, more than any scan has", all));
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < sizes.size(); ++a)
    if (layers ? a != *layers : sizes.size() == 3 || sizes[a] > 1) axes.push_back(a);
  if (axes.size() == 3) return axes;
  if (sizes.size() < 3)
    return failure(path,
                   fmt::format("contains a picture of {} dimensions; a volume is needed", sizes.size()));
  const bool colours =
      kinds.find("color") != std::string_view::npos || kinds.find("vector") != std::string_view::npos;
  return failure(path, fmt::format("has {} dimensions{}; one volume with one grey value per voxel is needed",
                                   sizes.size(), colours ? " (colours or vectors)" : ""));
}

// signs that convert the file's space to LPS; an unknown space is taken as LPS, with a warning
Vector3d to_lps(std::string_view space, std::vector<std::string>& warnings) {
  const std::string name = lower_case(space);
  if (name == "left-posterior-superior" || name == "lps") return {1, 1, 1};
  if (name == "right-anterior-superior" || name == "ras") return {-1, -1, 1};
  if (name == "left-anterior-superior" || name == "las") return {1, -1, 1};
  warnings.push_back(name.empty()
                         ? "the file does not state the patient's orientation; its axes were read as Left, "
                           "Posterior, Superior"
                         : "the space '" + name +
                               "' does not refer to the patient; it was read as Left, Posterior, Superior");
  return {1, 1, 1};
}

// one vector "(x,y,z)" per axis, "none" for an axis outside space; ends at what is neither
std::vector<std::vector<double>> vectors_in(std::string_view text) {
  std::vector<std::vector<double>> vectors;
  while (true) {
    text = trimmed(text);
    if (text.empty()) return vectors;
    if (text.starts_with("none")) {
      vectors.emplace_back();
      text.remove_prefix(4);
      continue;
    }
    const auto end = text.find(')');
    if (text.front() != '(' || end == std::string_view::npos) return vectors;
    std::string inside(text.substr(1, end - 1));
    std::ranges::replace(inside, ',', ' ');
    vectors.push_back(numbers_in(inside).value_or(std::vector<double>{}));
    text.remove_prefix(end + 1);
  }
}

Result<double> millimetres(const std::string& path, std::string_view units) {
  const std::string unit = lower_case(trimmed(units.substr(0, units.find('"', 1) + 1)));
  if (unit.empty() || unit == "\"mm\"" || unit == "\"\"" || unit.find("millimet") != std::string::npos)
    return 1;
  if (unit == "\"um\"" || unit.find("micro") != std::string::npos) return 0.001;
  if (unit == "\"cm\"") return 10;
  if (unit == "\"m\"" || unit == "\"meter\"" || unit == "\"meters\"") return 1000;
  return failure(path,
                 "has space units of " + printable(unit) + "; expected \"mm\", \"cm\", \"m\" or \"um\"");
}

Result<void> place(const std::string& path, const Nrrd& nrrd, const std::vector<std::size_t>& axes,
                   std::size_t dimension, ImageHeader& header) {
  const Vector3d flip = to_lps(nrrd.field("space"), header.warnings);
  const auto unit = millimetres(path, nrrd.field("space units"));
  if (!unit) return tl::unexpected(unit.error());
  const auto directions = vectors_in(nrrd.field("space directions"));
  const auto given_spacings = field_numbers(path, "'spacings'", nrrd.field("spacings"), dimension),
             given_thicknesses = field_numbers(path, "'thicknesses'", nrrd.field("thicknesses"), dimension);
  for (const auto& given : {given_spacings, given_thicknesses})
    if (!given) return tl::unexpected(given.error());
  const std::vector<double>&spacings = *given_spacings, &thicknesses = *given_thicknesses;
  const auto units = nrrd.field("units");
  const double own_unit = units.empty() ? *unit : millimetres(path, units).value_or(*unit);
  for (int c = 0; c < 3; ++c) {
    const std::size_t a = axes[static_cast<std::size_t>(c)];
    if (!directions.empty()) {
      if (a >= directions.size() || directions[a].size() != 3)
        return failure(
            path,
            fmt::format("has a damaged header: 'space directions' has no vector of three numbers for axis {}",
                        a + 1));
      header.grid.axes.col(c) = *unit * flip.cwiseProduct(Vector3d(directions[a].data()));
    } else if (a < spacings.size()) {
      header.grid.axes.col(c) = own_unit * spacings[a] * Vector3d::Unit(c);
    } else {
      return failure(path, "does not state its voxel size: it has neither 'space directions' nor 'spacings'");
    }
  }
  const auto along = [&](const std::vector<double>& list) {
    Vector3d lengths;
    for (int c = 0; c < 3; ++c) {
      const std::size_t a = axes[static_cast<std::size_t>(c)];
      lengths[c] = a < list.size() ? own_unit * std::abs(list[a]) : std::nan("");
    }
    return lengths;
  };
  std::vector<SizeField> fields;
  if (!directions.empty()) fields.push_back({"space directions", header.grid.axes.colwise().norm()});
  if (!spacings.empty()) fields.push_back({"spacings", along(spacings)});
  if (!thicknesses.empty()) fields.push_back({"thicknesses", along(thicknesses), true});
  const auto size = voxel_size(path, fields, header.warnings);
  if (!size) return tl::unexpected(size.error());
  resize_axes(header.grid.axes, *size);
  if (const std::string_view given = nrrd.field("space origin"); !given.empty()) {
    const auto origin = vectors_in(given);
    if (origin.size() != 1 || origin[0].size() != 3)
      return failure(path,
                     fmt::format("has a damaged header: 'space origin' is '{}'; expected one vector of three "
                                 "numbers, as (0,0,0)",
                                 printable(given)));
    header.grid.origin = *unit * flip.cwiseProduct(Vector3d(origin[0].data()));
  }
  return {};
}

Result<void> locate_voxels(const std::string& path, const Nrrd& nrrd, ImageHeader& header) {
  const std::string encoding = lower_case(nrrd.field("encoding"));
  header.text = encoding == "ascii" || encoding == "text" || encoding == "txt";
  if (encoding == "gzip" || encoding == "gz")
    header.packing = ByteSource::Packing::deflated;
  else if (encoding == "bzip2" || encoding == "bz2")
    header.packing = ByteSource::Packing::bzip2;
  else if (encoding != "raw" && !header.text)
    return failure(path, "has the unsupported encoding '" + printable(encoding) +
                             "'; expected raw, ascii, gzip or bzip2");
  const bool packed = header.packing != ByteSource::Packing::plain;
  const std::string_view field = nrrd.data_file();
  header.data_file = path;
  header.file_offset = nrrd.header_bytes;
  std::vector<std::string> files{path};
  if (!field.empty()) {
    auto named = named_files(path, field, nrrd.names,
                             header.grid.size[2] * (header.layers_interleaved ? 1 : header.layers));
    if (!named) return tl::unexpected(named.error());
    files = std::move(*named);
  }
  const auto number = [&](std::string_view one, std::string_view other) {
    const auto text = nrrd.field(one).empty() ? nrrd.field(other) : nrrd.field(one);
    return std::floor(number_in(text).value_or(0));
  };
  const double lines = number("line skip", "lineskip"), bytes = number("byte skip", "byteskip");
  if (!(lines >= 0 && lines < 1e6 && bytes >= -1 && bytes < (packed ? 1e9 : 1e12)) ||
      (field.empty() && lines > 0))
    return failure(path, "has a damaged header: 'line skip' or 'byte skip' is impossible");
  // -1: the voxels are the last bytes of the file
  if (bytes < 0 && (packed || header.text))
    return failure(
        path, "has 'byte skip: -1', which is impossible with compressed or text voxels; correct the header");
  header.stream_offset = static_cast<std::uint64_t>(std::max(bytes, 0.0));
  return set_voxel_files(header, files, {.lines = lines, .all_else = bytes < 0});
}

}  // namespace

Result<ImageHeader> read_nrrd_header(const std::string& path) {
  const auto nrrd = parse_nrrd(path);
  if (!nrrd) return tl::unexpected(nrrd.error());
  ImageHeader header;
  header.format = "NRRD";
  header.description = nrrd->field("content");
  if (const auto own = nrrd->keys.find("borelli quantity"); own != nrrd->keys.end())
    header.recorded_quantity = own->second;

  const std::string type = lower_case(nrrd->field("type"));
  const auto scalar = nrrd_scalar(type);
  if (!scalar) return failure(path, "has voxels of the unsupported type '" + printable(type) + "'");
  header.scalar = *scalar;
  const std::string endian = lower_case(nrrd->field("endian"));
  header.big_endian = endian == "big";

  const auto given_sizes = field_numbers(path, "'sizes'", nrrd->field("sizes"));
  if (!given_sizes) return tl::unexpected(given_sizes.error());
  const std::vector<double>& sizes = *given_sizes;
  if (number_in(nrrd->field("dimension")) != static_cast<double>(sizes.size()))
    return failure(path, "has a damaged header: 'dimension' and 'sizes' disagree");
  const auto layers = layer_axis(*nrrd, sizes);
  const auto axes = volume_axes(path, sizes, nrrd->field("kinds"), layers);
  if (!axes) return tl::unexpected(axes.error());
  if (layers) header.layers = whole_number(sizes[*layers]), header.layers_interleaved = *layers == 0;
  auto segments = segments_of(path, *nrrd, header.layers);
  if (!segments) return tl::unexpected(segments.error());
  header.segments = std::move(*segments);
  for (std::size_t c = 0; c < 3; ++c) header.grid.size[c] = whole_number(sizes[(*axes)[c]]);
  if (const auto placed = place(path, *nrrd, *axes, sizes.size(), header); !placed)
    return tl::unexpected(placed.error());
  if (const auto found = locate_voxels(path, *nrrd, header); !found) return tl::unexpected(found.error());
  if (scalar_bytes(*scalar) > 1 && !header.text && endian != "little" && endian != "big")
    return failure(path, "does not state its byte order ('endian: little' or 'endian: big')");
  return header;
}

Result<void> write_nrrd(const std::string& path, const Grid& grid, Scalar scalar,
                        std::span<const std::byte> voxels, const std::string& recorded_quantity) {
  auto sink = ByteSink::create(path, ByteSink::Packing::plain);
  if (!sink) return tl::unexpected(sink.error());
  const auto vector = [](const Vector3d& v) {
    return fmt::format("({},{},{})", exact(v[0]), exact(v[1]), exact(v[2]));
  };
  const std::string header = fmt::format(
      "NRRD0005\ntype: {}\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n"
      "space directions: {} {} {}\nkinds: domain domain domain\nendian: little\nencoding: gzip\n"
      "space units: \"mm\" \"mm\" \"mm\"\nspace origin: {}\nborelli quantity:={}\n\n",
      scalar_name(scalar), grid.size[0], grid.size[1], grid.size[2], vector(grid.axes.col(0)),
      vector(grid.axes.col(1)), vector(grid.axes.col(2)), vector(grid.origin), recorded_quantity);
  if (const auto done = sink->write(std::string_view(header)); !done) return done;
  sink->start_packing();
  if (const auto done = sink->write(voxels); !done) return done;
  return sink->close();
}

}  // namespace borelli
