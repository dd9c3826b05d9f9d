// MetaImage, header and voxels in one file (.mha) or several (.mhd and what it names).
//
// After MetaIO's own description, "Reference: Tags of MetaImage" (itk.org/Wiki/MetaIO). Coordinates are LPS,
// as in ITK. AnatomicalOrientation repeats TransformMatrix, often wrongly, and is ignored, as in ITK.
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <tuple>

#include "error/printable.hpp"
#include "segmentation/files/header_text.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/files/slice_files.hpp"
#include "segmentation/files/voxel_size.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct MetaImage {
  std::map<std::string, std::string, std::less<>> tags;
  std::vector<std::string> names;  // file names, one per line after "ElementDataFile = LIST"
  std::uint64_t header_bytes = 0;

  std::string_view tag(std::string_view name) const {
    const auto it = tags.find(name);
    return it == tags.end() ? std::string_view{} : std::string_view(it->second);
  }
  /// the value of the first of several synonymous tags that is present
  std::string_view any(std::initializer_list<std::string_view> names) const {
    for (const auto name : names)
      if (const auto found = tag(name); !found.empty()) return found;
    return {};
  }
  bool is_true(std::initializer_list<std::string_view> names) const {
    const std::string value = lower_case(any(names));
    return value == "true" || value == "t" || value == "1";
  }
};

Result<MetaImage> parse_metaimage(const std::string& path) {
  const auto text = read_header_text(path, [](std::string_view line) {
    return line.starts_with("ElementDataFile") && !names_follow(trimmed(line.substr(line.find('=') + 1)));
  });
  if (!text) return tl::unexpected(text.error());
  MetaImage meta;
  meta.header_bytes = text->end;
  for (const std::string& line : text->lines) {
    if (names_follow(meta.tag("ElementDataFile"))) {
      meta.names.push_back(line);
      continue;
    }
    const auto equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string_view whole = line;
    meta.tags[std::string(trimmed(whole.substr(0, equals)))] = trimmed(whole.substr(equals + 1));
  }
  if (meta.tag("NDims").empty() || meta.tag("DimSize").empty())
    return failure(path, "is not a MetaImage: its header lacks NDims or DimSize");
  if (meta.tag("ElementDataFile").empty())
    return failure(path, "is cut off or not a MetaImage: its header has no ElementDataFile");
  return meta;
}

std::optional<Scalar> scalar_of(std::string_view type) {
  static const std::map<std::string_view, Scalar> types{
      {"MET_CHAR", Scalar::i8},        {"MET_UCHAR", Scalar::u8},  {"MET_SHORT", Scalar::i16},
      {"MET_USHORT", Scalar::u16},     {"MET_INT", Scalar::i32},   {"MET_UINT", Scalar::u32},
      {"MET_LONG", Scalar::i32},       {"MET_ULONG", Scalar::u32}, {"MET_LONG_LONG", Scalar::i64},
      {"MET_ULONG_LONG", Scalar::u64}, {"MET_FLOAT", Scalar::f32}, {"MET_DOUBLE", Scalar::f64}};
  const auto it = types.find(type);
  if (it == types.end()) return std::nullopt;
  return it->second;
}

Result<void> check_dimensions(const std::string& path, const MetaImage& meta) {
  const auto given_sizes = field_numbers(path, "DimSize", meta.tag("DimSize"));
  if (!given_sizes) return tl::unexpected(given_sizes.error());
  const std::vector<double>& sizes = *given_sizes;
  if (sizes.empty() || number_in(meta.tag("NDims")) != static_cast<double>(sizes.size()))
    return failure(path, "has a damaged header: NDims and DimSize disagree");
  for (const double size : sizes)
    if (!(size >= 1 && size <= 100000) || size != std::floor(size))
      return failure(path, fmt::format("has a damaged header: an axis has {} voxels", size));
  if (sizes.size() < 3)
    return failure(path,
                   fmt::format("contains a picture of {} dimensions; a volume is needed", sizes.size()));
  for (std::size_t i = 3; i < sizes.size(); ++i)
    if (sizes[i] > 1)
      return failure(
          path,
          fmt::format("contains {} volumes along dimension {}; give a file with one three-dimensional volume",
                      sizes[i], i + 1));
  if (const auto channels = number_in(meta.tag("ElementNumberOfChannels")).value_or(1); channels != 1)
    return failure(
        path,
        fmt::format("contains {} values per voxel (colours or vectors); one grey value is needed", channels));
  return {};
}

// Row c of TransformMatrix is the direction of axis c; only the first three dimensions count. Rows that are
// not of unit length give the voxel size a second time.
Result<void> place(const std::string& path, const MetaImage& meta, ImageHeader& header) {
  Grid& grid = header.grid;
  const auto sizes = numbers_in(meta.tag("DimSize")).value_or(std::vector<double>{});
  const std::size_t n = sizes.size();
  const bool sizes_alone = meta.tag("ElementSpacing").empty();
  std::array<std::vector<double>, 4> numbers;  // spacing, size, matrix, origin
  const std::array<std::tuple<const char*, std::string_view, std::size_t>, 4> given{
      {{"ElementSpacing", meta.tag("ElementSpacing"), n},
       {"ElementSize", meta.tag("ElementSize"), n},
       {"TransformMatrix", meta.any({"TransformMatrix", "Orientation", "Rotation"}), n * n},
       {"Offset", meta.any({"Offset", "Position", "Origin"}), n}}};
  for (std::size_t f = 0; f < given.size(); ++f) {
    const auto& [name, text, count] = given[f];
    auto read = field_numbers(path, name, text, count);
    if (!read) return tl::unexpected(read.error());
    numbers[f] = *std::move(read);
  }
  const auto& [spacing_field, size_field, matrix, origin] = numbers;
  const std::vector<double>& spacing = sizes_alone ? size_field : spacing_field;
  if (spacing.empty()) return failure(path, "does not state its voxel size: it has no ElementSpacing");
  for (std::size_t c = 0; c < 3; ++c) {
    grid.size[c] = whole_number(sizes[c]);
    for (std::size_t r = 0; r < 3; ++r) {
      const double cosine = matrix.empty() ? (r == c ? 1.0 : 0.0) : matrix[c * n + r];
      grid.axes(static_cast<int>(r), static_cast<int>(c)) = spacing[c] * cosine;
    }
    grid.origin[static_cast<int>(c)] = origin.empty() ? 0 : origin[c];
  }
  const Vector3d spaced = Vector3d(spacing.data()).cwiseAbs();
  std::vector<SizeField> fields{{"ElementSpacing", spaced}};
  if (!sizes_alone && !size_field.empty())
    fields.push_back({"ElementSize", Vector3d(size_field.data()), true});
  const Vector3d rows = grid.axes.colwise().norm().transpose().cwiseQuotient(spaced);
  if (((rows.array() - 1).abs() > 0.01).any()) fields.push_back({"TransformMatrix", rows});
  const auto size = voxel_size(path, fields, header.warnings);
  if (!size) return tl::unexpected(size.error());
  resize_axes(grid.axes, *size);
  return {};
}

Result<void> locate_voxels(const std::string& path, const MetaImage& meta, ImageHeader& header) {
  const std::string binary = lower_case(meta.tag("BinaryData"));
  header.text = binary == "false" || binary == "f" || binary == "0";
  if (meta.is_true({"CompressedData"})) header.packing = ByteSource::Packing::deflated;
  const std::string_view file = meta.tag("ElementDataFile");
  if (file == "LOCAL" || file == "Local" || file == "local") {
    header.data_file = path;
    header.file_offset = meta.header_bytes;
    return {};
  }
  const auto files = named_files(path, file, meta.names, header.grid.size[2]);
  if (!files) return tl::unexpected(files.error());
  const double bytes = number_in(meta.tag("HeaderSize")).value_or(0);
  if (!(bytes >= -1 && bytes < 1e12)) return failure(path, "has a damaged header: HeaderSize is impossible");
  if (bytes < 0 && (header.packing != ByteSource::Packing::plain || header.text))
    return failure(
        path,
        "has 'HeaderSize = -1', which is impossible with compressed or text voxels; correct the header");
  return set_voxel_files(header, *files,
                         {.bytes = static_cast<std::uint64_t>(std::max(bytes, 0.0)), .all_else = bytes < 0});
}

}  // namespace

Result<ImageHeader> read_metaimage_header(const std::string& path) {
  const auto meta = parse_metaimage(path);
  if (!meta) return tl::unexpected(meta.error());
  if (const auto fine = check_dimensions(path, *meta); !fine) return tl::unexpected(fine.error());
  ImageHeader header;
  header.format = "MetaImage";
  header.description = meta->tag("Comment");
  if (header.description.starts_with("borelli ")) header.recorded_quantity = header.description.substr(8);

  std::string_view type = meta->tag("ElementType");
  if (type.ends_with("_ARRAY")) type.remove_suffix(6);
  const auto scalar = scalar_of(type);
  if (!scalar) return failure(path, "has voxels of the unsupported type '" + printable(type) + "'");
  header.scalar = *scalar;
  header.big_endian = meta->is_true({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"});
  header.slope = number_in(meta->tag("ElementToIntensityFunctionSlope")).value_or(header.slope);
  header.intercept = number_in(meta->tag("ElementToIntensityFunctionOffset")).value_or(header.intercept);

  if (const auto placed = place(path, *meta, header); !placed) return tl::unexpected(placed.error());
  if (const auto found = locate_voxels(path, *meta, header); !found) return tl::unexpected(found.error());
  return header;
}

Result<void> write_metaimage(const std::string& path, const Grid& grid, Scalar scalar,
                             std::span<const std::byte> voxels, const std::string& recorded_quantity) {
  // readers of MetaImage treat TransformMatrix as a rotation; a cosine above 1e-6 would move voxels by more
  // than rounding
  if (shear(grid) > 1e-6) {
    return failure(
        path,
        fmt::format(
            "was not written: MetaImage cannot store sheared axes (cosine {:.2g}); write .nii.gz or .nrrd",
            shear(grid)));
  }
  auto sink = ByteSink::create(path, ByteSink::Packing::plain);
  if (!sink) return tl::unexpected(sink.error());
  const auto three = [](const Vector3d& v) {
    return fmt::format("{} {} {}", exact(v[0]), exact(v[1]), exact(v[2]));
  };
  const Vector3d spacing = grid.spacing();
  std::string cosines;
  for (int c = 0; c < 3; ++c) cosines += (c ? " " : "") + three(grid.axes.col(c) / spacing[c]);
  const std::string start = fmt::format(
      "ObjectType = Image\nNDims = 3\nComment = borelli {}\nBinaryData = True\nBinaryDataByteOrderMSB = "
      "False\nCompressedData = True\n"
      "CompressedDataSize = ",
      recorded_quantity);
  const std::string rest = fmt::format(
      "\nTransformMatrix = {}\nOffset = {}\nCenterOfRotation = 0 0 0\nElementSpacing = {}\nDimSize = {} {} "
      "{}\n"
      "ElementType = {}\nElementDataFile = LOCAL\n",
      cosines, three(grid.origin), three(spacing), grid.size[0], grid.size[1], grid.size[2],
      scalar == Scalar::u8 ? "MET_UCHAR" : "MET_SHORT");
  const std::string room(16, ' ');  // placeholder of the packed size, known only at the end
  if (const auto done = sink->write(std::string_view(start + room + rest)); !done) return done;
  sink->start_packing();
  if (const auto done = sink->write(voxels); !done) return done;
  if (const auto done = sink->end_packing(); !done) return done;
  const std::uint64_t packed = sink->size() - (start.size() + room.size() + rest.size());
  if (const auto done = sink->overwrite(start.size(), std::to_string(packed)); !done) return done;
  return sink->close();
}

}  // namespace borelli
