#include "segmentation/files/dicom_slice.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string_view>
#include <type_traits>

#include "process/child.hpp"
#include "segmentation/files/byte_stream.hpp"
#include "segmentation/files/dicom_codecs.hpp"
#include "segmentation/files/dicom_elements.hpp"
#include "segmentation/files/dicom_rle.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Unit of the last decimal of a number's text: 0.01 for "12.50", 1 for "12".
double last_decimal(std::string_view text) {
  const auto e = text.find_first_of("eE");
  const double exponent = e == std::string_view::npos ? 0 : number_in(text.substr(e + 1)).value_or(0);
  text = trimmed(text.substr(0, e));
  const auto point = text.find('.');
  const double decimals = point == std::string_view::npos ? 0 : double(text.size() - point - 1);
  return std::pow(10.0, exponent - decimals);
}

// The first field that has a comma in its numbers, as "name 'text'"; empty: none. DICOM allows no comma
// (PS3.5, 6.2, DS).
std::string field_with_comma(const DicomItem& item) {
  static constexpr std::array<std::pair<std::uint32_t, const char*>, 7> read{
      {{0x00200032, "ImagePositionPatient"},
       {0x00200037, "ImageOrientationPatient"},
       {0x00280030, "PixelSpacing"},
       {0x00281052, "RescaleIntercept"},
       {0x00281053, "RescaleSlope"},
       {0x00180050, "SliceThickness"},
       {0x00180088, "SpacingBetweenSlices"}}};
  for (const auto& [tag, name] : read)
    if (const std::string text = item.text(tag); text.find(',') != std::string::npos)
      return fmt::format("{} '{}'", name, text);
  return "";
}

std::string bad_comma(const std::string& found) {
  return "contains numbers with decimal commas (" + found +
         "); DICOM needs decimal points and separates numbers by backslashes; export it again with decimal "
         "points";
}

double first_decimal(const DicomItem& item, std::uint32_t tag) {
  const auto list = item.decimals(tag);
  return list.empty() || !(std::abs(list[0]) < 1e6) ? 0 : list[0];
}

void take_spacing(const DicomItem& item, DicomSlice& slice) {
  slice.thickness = std::max(first_decimal(item, 0x00180050), 0.0);
  slice.spacing_between = std::abs(first_decimal(item, 0x00180088));  // negative in nuclear medicine
}

void take_geometry(const DicomItem& elements, DicomSlice& slice) {
  const auto position = elements.decimals(0x00200032), axes = elements.decimals(0x00200037);
  const auto spacing = elements.decimals(0x00280030);
  if (position.size() != 3 || axes.size() != 6 || spacing.size() != 2) return;
  const Vector3d row(axes.data()), column(axes.data() + 3), first(position.data());
  if (!first.allFinite() || first.norm() > 1e6 || !row.allFinite() || !column.allFinite()) return;
  if (!(row.norm() > 0.5 && column.norm() > 0.5)) return;
  if (!(row.normalized().cross(column.normalized()).norm() > 0.1)) return;
  if (!(spacing[0] > 0 && spacing[1] > 0 && spacing[0] < 1000 && spacing[1] < 1000)) return;
  slice.position = first;
  const std::string text = elements.text(0x00200032);
  for (std::size_t n = 0, from = 0; n < 3; ++n) {
    const auto to = std::min(text.find('\\', from), text.size());
    slice.position_decimal[static_cast<Eigen::Index>(n)] =
        last_decimal(std::string_view(text).substr(from, to - from));
    from = std::min(to + 1, text.size());
  }
  slice.along_row = row.normalized(), slice.along_column = column.normalized();
  slice.row_spacing = spacing[0], slice.column_spacing = spacing[1];  // "adjacent rows \ adjacent columns"
}

void take_pixels(const DicomElements& elements, DicomSlice& slice) {
  DicomPixels& p = slice.pixels;
  p.bits_allocated = elements.number(0x00280100).value_or(16);
  p.bits_stored = elements.number(0x00280101).value_or(static_cast<std::uint16_t>(p.bits_allocated));
  p.high_bit = elements.number(0x00280102).value_or(static_cast<std::uint16_t>(p.bits_stored - 1));
  p.is_signed = elements.number(0x00280103).value_or(0) == 1;
  p.big_endian = elements.big_endian, p.fragments = elements.fragments, p.packing = elements.transfer_syntax;
  p.deflated_from = elements.deflated_from;
  p.offset = elements.pixel_offset, p.bytes = elements.pixel_bytes;
  slice.samples_per_pixel = elements.number(0x00280002).value_or(1);
  if (const auto frames = elements.decimals(0x00280008); !frames.empty() && frames[0] > 1)
    slice.frames = static_cast<int>(std::min(frames[0], 1e6));
  if (const auto padding = elements.number(0x00280120))
    slice.padding = p.is_signed ? static_cast<std::int16_t>(*padding) : *padding;
}

// PS3.5, annex A.4
std::string packing_name(const std::string& uid) {
  static const std::map<std::string_view, std::string_view> names{
      {"1.2.840.10008.1.2.4.50", "JPEG baseline"},      {"1.2.840.10008.1.2.4.51", "JPEG extended"},
      {"1.2.840.10008.1.2.4.57", "JPEG lossless"},      {"1.2.840.10008.1.2.4.70", "JPEG lossless"},
      {"1.2.840.10008.1.2.4.80", "JPEG-LS lossless"},   {"1.2.840.10008.1.2.4.81", "JPEG-LS near-lossless"},
      {"1.2.840.10008.1.2.4.90", "JPEG 2000 lossless"}, {"1.2.840.10008.1.2.4.91", "JPEG 2000"},
      {"1.2.840.10008.1.2.5", "RLE lossless"}};
  const auto it = names.find(uid);
  return it == names.end() ? uid : std::string(it->second);
}

constexpr const char* bad_scaling =
    "is a damaged DICOM file: its rescale slope or intercept is not a number, or the slope is zero";

// Text that is not a number becomes NaN, which scaling_fits() refuses.
void take_scaling(const DicomItem& item, DicomSlice& slice) {
  const auto slope = number_in(item.text(0x00281053)), intercept = number_in(item.text(0x00281052));
  slice.slope = slope.value_or(slice.slope), slice.intercept = intercept.value_or(slice.intercept);
  slice.is_scaled = slice.is_scaled || slope || intercept;
}
bool scaling_fits(const DicomSlice& slice) {
  return std::isfinite(slice.slope) && slice.slope != 0 && std::isfinite(slice.intercept);
}

DicomSlice take(const std::string& path, const DicomElements& elements) {
  DicomSlice slice;
  slice.path = path;
  slice.series_uid = elements.text(0x0020000e);
  slice.modality = elements.text(0x00080060), slice.series_description = elements.text(0x0008103e);
  slice.patient_position = elements.text(0x00185100);
  slice.patient_sex = elements.text(0x00100040);
  slice.patient_age = elements.text(0x00101010);
  slice.rescale_type = elements.text(0x00281054);
  slice.rows = elements.number(0x00280010).value_or(0),
  slice.columns = elements.number(0x00280011).value_or(0);
  take_scaling(elements, slice);
  slice.acquisition = elements.text(0x00200012), slice.temporal_position = elements.text(0x00200100);
  slice.echo = elements.text(0x00180086), slice.image_type = elements.text(0x00080008);
  take_geometry(elements, slice);
  take_spacing(elements, slice);
  if (const auto location = elements.decimals(0x00201041); location.size() == 1) slice.location = location[0];
  slice.reconstruction_diameter = std::max(first_decimal(elements, 0x00181100), 0.0);
  take_pixels(elements, slice);
  if (elements.packed) slice.packing = packing_name(elements.transfer_syntax);
  return slice;
}

// Sets `p` to the pixels of one frame. Packed frames have one fragment each, as in nearly all files.
void part_pixels(const DicomSlice& whole, std::size_t frame, DicomPixels& p) {
  if (!whole.pixels.fragments.empty()) {
    p.fragments = {whole.pixels.fragments[frame]};
    return;
  }
  const auto bits = static_cast<std::uint64_t>(whole.rows) * static_cast<std::uint64_t>(whole.columns) *
                    static_cast<std::uint64_t>(p.bits_allocated);
  const std::uint64_t before = std::min(p.bytes, frame * bits / 8);
  p.offset += before;
  p.bytes = std::min(bits / 8, p.bytes - before);
}

Result<std::vector<DicomSlice>> frames_of(const DicomElements& elements, const DicomSlice& whole) {
  const auto groups = elements.sequences.find(0x52009230);
  if (groups == elements.sequences.end()) return std::vector{whole};
  const auto& per_frame = groups->second;
  if (per_frame.size() != static_cast<std::size_t>(whole.frames))
    return failure(whole.path, fmt::format("is a damaged DICOM file: it has {} frames and describes {}",
                                           whole.frames, per_frame.size()));
  const DicomItem* shared = elements.item(0x52009229);
  if (const std::size_t pieces = whole.pixels.fragments.size(); pieces > 0 && pieces != per_frame.size())
    return failure(whole.path, fmt::format("has {} frames in {} compressed pieces without a table of "
                                           "offsets; decompress it first (dcmdjpeg, gdcmconv --raw)",
                                           per_frame.size(), pieces));
  DicomSlice alike = whole;  // what all frames share
  alike.frames = 1;
  alike.position.reset();
  alike.pixels.fragments.clear();
  std::vector<DicomSlice> slices;
  for (std::size_t n = 0; n < per_frame.size(); ++n) {
    // a macro of this frame, else the shared one
    const auto macro = [&](std::uint32_t tag) {
      const DicomItem* own = per_frame[n].item(tag);
      return own || !shared ? own : shared->item(tag);
    };
    DicomSlice s = alike;
    DicomItem geometry;
    for (const auto& [group, tag] :
         {std::pair{0x00209113U, 0x00200032U}, {0x00209116U, 0x00200037U}, {0x00289110U, 0x00280030U}})
      if (const DicomItem* m = macro(group)) geometry.values[tag] = m->text(tag);
    std::string comma = field_with_comma(geometry);
    take_geometry(geometry, s);
    if (const DicomItem* m = macro(0x00289110)) take_spacing(*m, s);
    if (const DicomItem* m = macro(0x00289145)) {
      if (comma.empty()) comma = field_with_comma(*m);
      take_scaling(*m, s);
      s.rescale_type = m->text(0x00281054);
    }
    if (const DicomItem* m = macro(0x00209111)) {
      s.acquisition =
          fmt::format("{} {}", m->text(0x00209056), m->number(0x00209156).value_or(0));  // stack, acquisition
      if (const auto time = m->number(0x00209128)) s.temporal_position = fmt::format("{}", *time);
    }
    if (const DicomItem* m =
            macro(0x00189114)) {  // echo time, a double in the file's byte order: compared as bytes
      const auto echo = m->values.find(0x00189082);
      if (echo != m->values.end()) s.echo = echo->second;
    }
    for (const std::uint32_t tag : {0x00189329U, 0x00189226U})
      if (const DicomItem* m = macro(tag)) s.image_type = m->text(0x00080007);
    if (!comma.empty()) return failure(whole.path, bad_comma(comma));
    if (!scaling_fits(s)) return failure(whole.path, bad_scaling);
    part_pixels(whole, n, s.pixels);
    slices.push_back(std::move(s));
  }
  return slices;
}

// Bytes of a slice's unpacked pixels.
double plain_size(const DicomSlice& slice) {
  return double(slice.rows) * double(slice.columns) * (slice.pixels.bits_allocated / 8);
}

// All fragments as one stream, padded to even length as DICOM requires.
Result<std::vector<std::byte>> packed_stream(const DicomSlice& slice, DicomBytes& file) {
  std::vector<std::byte> stream;
  for (const auto& [offset, length] : slice.pixels.fragments) {
    const std::size_t start = stream.size();
    stream.resize(start + length);
    if (const auto got = file.read(slice, offset, std::span(stream).subspan(start)); !got)
      return tl::unexpected(got.error());
  }
  if (stream.size() % 2) stream.push_back(std::byte{0});
  return stream;
}

constexpr std::string_view rle_syntax = "1.2.840.10008.1.2.5";

bool needs_codec(const DicomSlice& slice) {
  return !slice.pixels.fragments.empty() && slice.pixels.packing != rle_syntax;
}

Result<void> unpacked_bytes(const DicomSlice& slice, DicomBytes& file, std::span<std::byte> to,
                            DicomPixels& p) {
  const auto stream = packed_stream(slice, file);
  if (!stream) return tl::unexpected(stream.error());
  if (needs_codec(slice)) return unpack_by_codec(slice, *stream, to, p);
  const auto wrong = unpack_rle(*stream, static_cast<std::size_t>(p.bits_allocated) / 8, to);
  if (wrong.empty()) return {};
  return failure(slice.path, fmt::format("contains damaged pixels (RLE: {})", wrong));
}

bool consistent(const DicomPixels& p) {
  return p.bits_stored >= 1 && p.bits_stored <= p.bits_allocated && p.high_bit + 1 >= p.bits_stored &&
         p.high_bit < p.bits_allocated;
}

// Calls f(value); value(word) extracts the pixel value from a stored word by HighBit and BitsStored.
template <class F>
void with_value(const DicomPixels& p, F&& f) {
  const int up = 31 - p.high_bit, down = 32 - p.bits_stored;
  if (p.is_signed)
    f([=](std::uint32_t word) { return static_cast<std::int32_t>(word << up) >> down; });
  else
    f([=](std::uint32_t word) { return static_cast<std::int32_t>(word << up >> down); });
}

template <class Word>
Word in_own_order(Word word, bool turned) {
  if constexpr (sizeof(Word) == 2) return turned ? __builtin_bswap16(word) : word;
  if constexpr (sizeof(Word) == 4) return turned ? __builtin_bswap32(word) : word;
  return word;
}

// converts words of the size of T to values of T, in place
template <class T>
void decode(std::span<T> values, const DicomPixels& p) {
  using Word = std::make_unsigned_t<T>;
  if (p.bits_stored == 8 * int(sizeof(T)) && !p.big_endian) return;  // words are already the values
  with_value(p, [&, turned = p.big_endian](const auto& value) {
    for (T& v : values) v = static_cast<T>(value(in_own_order(static_cast<Word>(v), turned)));
  });
}

// converts words of another size to values of T
template <class Word, class T>
void decode(std::span<const std::byte> bytes, std::span<T> values, const DicomPixels& p) {
  with_value(p, [&, turned = p.big_endian](const auto& value) {
    for (std::size_t n = 0; n < values.size(); ++n) {
      Word word;
      std::memcpy(&word, bytes.data() + n * sizeof(Word), sizeof word);
      values[n] = static_cast<T>(value(in_own_order(word, turned)));
    }
  });
}

Result<DicomSlice> checked(const std::string& path, const DicomElements& elements) {
  DicomSlice slice = take(path, elements);
  if (slice.rows == 0 || slice.columns == 0)
    return failure(path, "is a damaged DICOM file: it has pixels but no rows and columns");
  if (const auto comma = field_with_comma(elements); !comma.empty()) return failure(path, bad_comma(comma));
  if (!scaling_fits(slice)) return failure(path, bad_scaling);
  return slice;
}

}  // namespace

Vector3d DicomSlice::normal() const { return along_row.cross(along_column).normalized(); }

Result<std::optional<DicomSlice>> read_dicom_header(const std::string& path) {
  const auto elements = read_dicom_elements(path);
  if (!elements) return tl::unexpected(elements.error());
  if (!*elements || (*elements)->pixel_offset == 0) return std::nullopt;  // also reports, plans, directories
  auto slice = checked(path, **elements);
  if (!slice) return tl::unexpected(slice.error());
  return std::move(*slice);
}

Result<std::vector<DicomSlice>> read_dicom_slices(const std::string& path) {
  const auto elements = read_dicom_elements(path);
  if (!elements) return tl::unexpected(elements.error());
  if (!*elements || (*elements)->pixel_offset == 0) return std::vector<DicomSlice>{};
  const auto whole = checked(path, **elements);
  if (!whole) return tl::unexpected(whole.error());
  return frames_of(**elements, *whole);
}

namespace {

// Reads one slice in this process.
template <class T>
Result<void> read_slice(const DicomSlice& slice, DicomBytes& file, std::span<T> to) {
  if (const auto fits = check_pixels(slice); !fits) return fits;
  const auto width = static_cast<std::size_t>(slice.pixels.bits_allocated) / 8;
  DicomPixels p = slice.pixels;
  if (!consistent(p))
    return failure(slice.path, fmt::format("is a damaged DICOM file: it stores {} bits up to bit {} of {}",
                                           p.bits_stored, p.high_bit, p.bits_allocated));
  std::vector<std::byte> apart(width == sizeof(T) ? 0 : to.size() * width);
  const auto bytes = width == sizeof(T) ? std::as_writable_bytes(to) : std::span(apart);
  const auto read =
      p.fragments.empty() ? file.read(slice, p.offset, bytes) : unpacked_bytes(slice, file, bytes, p);
  if (!read) return read;
  if (!consistent(p)) return failure(slice.path, "has compressed pixels that contradict their own header");

  if (width == sizeof(T))
    decode(to, p);
  else if (width == 1)
    decode<std::uint8_t>(bytes, to, p);
  else if (width == 2)
    decode<std::uint16_t>(bytes, to, p);
  else
    decode<std::uint32_t>(bytes, to, p);
  return {};
}

// Pixels for one child: enough to outweigh its start, few enough to spare memory.
constexpr std::size_t bytes_of_child = std::size_t{64} << 20;

template <class T>
Result<void> read_in_child(std::span<const DicomSlice> slices, std::span<T> to) {
  if (auto ready = load_codecs(); !ready) return ready;
  const std::size_t area = to.size() / slices.size();
  const std::string& path = slices.front().path;
  auto pixels = SharedBytes::make(path, to.size_bytes()), at = SharedBytes::make(path, sizeof(std::uint32_t));
  if (!pixels) return tl::unexpected(pixels.error());
  if (!at) return tl::unexpected(at.error());
  const auto shared = reinterpret_cast<T*>(pixels->bytes().data());
  const auto current = reinterpret_cast<volatile std::uint32_t*>(at->bytes().data());
  // codecs are at least ten times as fast
  const double seconds = 4 + double(to.size()) / 1e6;
  const ChildLimits limits{.seconds = 10 * seconds,  // wall clock, for a busy machine
                           .processor_seconds = seconds,
                           .bytes = (std::uint64_t{256} << 20) + 32 * area};
  const auto done = in_child("", "decompressing its pixels (" + slices.front().packing + ")", limits, [&] {
    DicomBytes file;
    Result<void> read;
    for (std::size_t n = 0; n < slices.size() && read; ++n) {
      *current = static_cast<std::uint32_t>(n);
      read = read_slice(slices[n], file, std::span(shared + n * area, area));
    }
    return read;
  });
  if (!done && done.error().where.empty())
    return failure(slices[*current].path, done.error().what + "; the pixels are damaged");
  if (done) std::memcpy(to.data(), shared, to.size_bytes());
  return done;
}

}  // namespace

Result<void> check_pixels(const DicomSlice& slice) {
  const DicomPixels& p = slice.pixels;
  if (p.bits_allocated != 8 && p.bits_allocated != 16 && p.bits_allocated != 32)
    return failure(slice.path, fmt::format("has pixels of {} bits; expected 8, 16 or 32", p.bits_allocated));
  double bytes = 0;
  for (const auto& fragment : p.fragments) bytes += fragment.second;
  if (p.fragments.empty()) bytes = double(p.bytes);
  if (needs_codec(slice) || plain_size(slice) <= (p.fragments.empty() ? bytes : most_of_rle(bytes)))
    return {};
  return failure(
      slice.path,
      fmt::format("is cut off or damaged: it has {:.0f} bytes of {}pixels, but its header states {:.0f}",
                  bytes, p.fragments.empty() ? "" : "packed ", plain_size(slice)));
}

template <class T>
Result<void> read_dicom_pixels(std::span<const DicomSlice> slices, std::span<T> to,
                               const std::function<void(std::size_t)>& done) {
  DicomBytes file;
  const std::size_t area = to.size() / std::max<std::size_t>(slices.size(), 1);
  const std::size_t most =
      std::max<std::size_t>(bytes_of_child / (sizeof(T) * std::max<std::size_t>(area, 1)), 1);
  for (std::size_t n = 0; n < slices.size();) {
    std::size_t end = n + 1;
    if (needs_codec(slices[n]))
      while (end < slices.size() && end - n < most && needs_codec(slices[end])) ++end;
    const auto some = to.subspan(n * area, (end - n) * area);
    const auto read = needs_codec(slices[n]) ? read_in_child(slices.subspan(n, end - n), some)
                                             : read_slice(slices[n], file, some);
    if (!read) return read;
    n = end;
    if (done) done(n);
  }
  return {};
}

template Result<void> read_dicom_pixels(std::span<const DicomSlice>, std::span<std::int16_t>,
                                        const std::function<void(std::size_t)>&);
template Result<void> read_dicom_pixels(std::span<const DicomSlice>, std::span<std::int32_t>,
                                        const std::function<void(std::size_t)>&);

struct DicomBytes::Open {
  std::string path;
  ByteSource source;
  std::uint64_t position;
};

DicomBytes::DicomBytes() = default;
DicomBytes::~DicomBytes() = default;

Result<void> DicomBytes::read(const DicomSlice& slice, std::uint64_t offset, std::span<std::byte> to) {
  const std::uint64_t deflated = slice.pixels.deflated_from;
  if (deflated == 0 || !open_ || open_->path != slice.path || open_->position > offset) {
    auto source = deflated ? ByteSource::open(slice.path, ByteSource::Packing::raw, deflated)
                           : ByteSource::open(slice.path, ByteSource::Packing::plain, offset);
    if (!source) return tl::unexpected(source.error());
    open_.reset(new Open{slice.path, std::move(*source), deflated ? 0 : offset});
  }
  const auto skipped = open_->source.skip(offset - open_->position);
  if (!skipped) return tl::unexpected(skipped.error());
  const auto got = open_->source.read(to);
  if (!got) return tl::unexpected(got.error());
  open_->position = offset + *got;
  if (*got < to.size()) return failure(slice.path, "is cut off within its pixels");
  return {};
}

}  // namespace borelli
