#include "segmentation/dicom_slice.hpp"

#include <fmt/format.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <map>
#include <string_view>
#include <type_traits>

#include "segmentation/byte_stream.hpp"
#include "segmentation/dicom_elements.hpp"
#include "segmentation/header_text.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

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
    "is a damaged DICOM file: its rescaling is not a number, or has a slope of zero";

// What is no number becomes NaN, which scaling_fits() refuses.
void take_scaling(const DicomItem& item, DicomSlice& slice) {
  slice.slope = number_in(item.text(0x00281053)).value_or(slice.slope);
  slice.intercept = number_in(item.text(0x00281052)).value_or(slice.intercept);
}
bool scaling_fits(const DicomSlice& slice) {
  return std::isfinite(slice.slope) && slice.slope != 0 && std::isfinite(slice.intercept);
}

DicomSlice take(const std::string& path, const DicomElements& elements) {
  DicomSlice slice;
  slice.path = path;
  slice.instance_uid = elements.text(0x00080018), slice.series_uid = elements.text(0x0020000e);
  slice.modality = elements.text(0x00080060), slice.series_description = elements.text(0x0008103e);
  slice.patient_position = elements.text(0x00185100);
  slice.rescale_type = elements.text(0x00281054);
  slice.rows = elements.number(0x00280010).value_or(0),
  slice.columns = elements.number(0x00280011).value_or(0);
  take_scaling(elements, slice);
  slice.acquisition = elements.text(0x00200012), slice.temporal_position = elements.text(0x00200100);
  slice.echo = elements.text(0x00180086), slice.image_type = elements.text(0x00080008);
  take_geometry(elements, slice);
  take_pixels(elements, slice);
  if (elements.packed) slice.packing = packing_name(elements.transfer_syntax);
  return slice;
}

// Where each frame of packed pixels is among their fragments: one each, as nearly all files have it.
Result<void> part_pixels(const DicomSlice& whole, std::size_t frames, std::size_t frame, DicomPixels& p) {
  if (p.fragments.empty()) {
    const auto bits = static_cast<std::uint64_t>(whole.rows) * static_cast<std::uint64_t>(whole.columns) *
                      static_cast<std::uint64_t>(p.bits_allocated);
    p.offset += frame * bits / 8;
    p.bytes = std::min(bits / 8, p.bytes - std::min(p.bytes, frame * bits / 8));
    return {};
  }
  if (p.fragments.size() != frames)
    return failure(whole.path,
                   fmt::format("has {} frames packed into {} pieces, so that they cannot be told apart here; "
                               "unpack it first (dcmdjpeg, gdcmconv --raw)",
                               frames, p.fragments.size()));
  p.fragments = {p.fragments[frame]};
  return {};
}

Result<std::vector<DicomSlice>> frames_of(const DicomElements& elements, const DicomSlice& whole) {
  const auto groups = elements.sequences.find(0x52009230);
  if (groups == elements.sequences.end()) return std::vector{whole};
  const auto& per_frame = groups->second;
  if (per_frame.size() != static_cast<std::size_t>(whole.frames))
    return failure(whole.path, fmt::format("is a damaged DICOM file: {} frames, of which {} are described",
                                           whole.frames, per_frame.size()));
  const DicomItem* shared = elements.item(0x52009229);
  std::vector<DicomSlice> slices;
  for (std::size_t n = 0; n < per_frame.size(); ++n) {
    // a macro of this frame, else the one that all share
    const auto macro = [&](std::uint32_t tag) {
      const DicomItem* own = per_frame[n].item(tag);
      return own || !shared ? own : shared->item(tag);
    };
    DicomSlice s = whole;
    s.frames = 1;
    s.position.reset();
    s.instance_uid += fmt::format(".{}", n + 1);
    DicomItem geometry;
    for (const auto& [group, tag] :
         {std::pair{0x00209113U, 0x00200032U}, {0x00209116U, 0x00200037U}, {0x00289110U, 0x00280030U}})
      if (const DicomItem* m = macro(group)) geometry.values[tag] = m->text(tag);
    take_geometry(geometry, s);
    if (const DicomItem* m = macro(0x00289145)) {
      take_scaling(*m, s);
      s.rescale_type = m->text(0x00281054);
    }
    if (const DicomItem* m = macro(0x00209111)) {
      s.acquisition =
          fmt::format("{} {}", m->text(0x00209056), m->number(0x00209156).value_or(0));  // stack, acquisition
      if (const auto time = m->number(0x00209128)) s.temporal_position = fmt::format("{}", *time);
    }
    if (const DicomItem* m =
            macro(0x00189114)) {  // echo time, a double of the file's byte order: told apart as bytes
      const auto echo = m->values.find(0x00189082);
      if (echo != m->values.end()) s.echo = echo->second;
    }
    for (const std::uint32_t tag : {0x00189329U, 0x00189226U})
      if (const DicomItem* m = macro(tag)) s.image_type = m->text(0x00080007);
    if (!scaling_fits(s)) return failure(whole.path, bad_scaling);
    if (const auto parted = part_pixels(whole, per_frame.size(), n, s.pixels); !parted)
      return tl::unexpected(parted.error());
    slices.push_back(std::move(s));
  }
  return slices;
}

Result<void> plain_bytes(const DicomSlice& slice, std::span<std::byte> to) {
  if (slice.pixels.bytes < to.size()) {
    return failure(
        slice.path,
        fmt::format("is cut off or damaged: it holds {} bytes of pixels where its header promises {}",
                    slice.pixels.bytes, to.size()));
  }
  auto source = ByteSource::open(slice.path, ByteSource::Packing::plain, slice.pixels.offset);
  if (!source) return tl::unexpected(source.error());
  const auto got = source->read(to);
  if (!got) return tl::unexpected(got.error());
  if (*got < to.size()) return failure(slice.path, "is cut off within its pixels");
  return {};
}

// One stream of all fragments; of even length, as DICOM has it.
Result<std::vector<char>> packed_stream(const DicomSlice& slice) {
  std::vector<char> stream;
  for (const auto& [offset, length] : slice.pixels.fragments) {
    auto source = ByteSource::open(slice.path, ByteSource::Packing::plain, offset);
    if (!source) return tl::unexpected(source.error());
    const std::size_t start = stream.size();
    stream.resize(start + length);
    const auto got = source->read(std::as_writable_bytes(std::span(stream).subspan(start)));
    if (!got) return tl::unexpected(got.error());
    if (*got < length) return failure(slice.path, "is cut off within its pixels");
  }
  if (stream.size() % 2) stream.push_back(0);
  return stream;
}

// GDCM's codecs unpack a picture that is put together here: GDCM's reader of files aborts on damaged ones.
// What the codec finds (JPEG may know better than the header) replaces what the header says of the pixels.
Result<void> unpacked_bytes(const DicomSlice& slice, std::span<std::byte> to, DicomPixels& p) try {
  gdcm::Trace::DebugOff(), gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff();  // a library does not print
  const auto stream = packed_stream(slice);
  if (!stream) return tl::unexpected(stream.error());
  const auto syntax = gdcm::TransferSyntax::GetTSType(p.packing.c_str());
  if (syntax == gdcm::TransferSyntax::TS_END)
    return failure(slice.path, "has pixels packed in a way that is not known here (" + slice.packing + ")");

  gdcm::Fragment fragment;
  fragment.SetByteValue(stream->data(), static_cast<std::uint32_t>(stream->size()));
  gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
  fragments->AddFragment(fragment);
  gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
  element.SetVR(gdcm::VR::OB);
  element.SetValue(*fragments);

  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, static_cast<unsigned>(slice.columns)),
      image.SetDimension(1, static_cast<unsigned>(slice.rows));
  const auto bits = [](int n) { return static_cast<unsigned short>(n); };
  image.SetPixelFormat(
      gdcm::PixelFormat(1, bits(p.bits_allocated), bits(p.bits_stored), bits(p.high_bit), p.is_signed));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax(syntax));
  image.SetDataElement(element);
  if (image.GetBufferLength() != to.size() || !image.GetBuffer(reinterpret_cast<char*>(to.data())))
    return failure(slice.path,
                   "has pixels that cannot be unpacked: cut off or damaged (" + slice.packing + ")");
  const gdcm::PixelFormat& format = image.GetPixelFormat();
  if (format.GetBitsAllocated() != p.bits_allocated)
    return failure(slice.path, fmt::format("unpacks to pixels of {} bits where its header promises {}",
                                           format.GetBitsAllocated(), p.bits_allocated));
  p.bits_stored = format.GetBitsStored(), p.high_bit = format.GetHighBit();
  p.is_signed = format.GetPixelRepresentation() == 1;
  return {};
} catch (const std::exception& trouble) {
  return failure(slice.path, std::string("has pixels that cannot be unpacked: ") + trouble.what());
}

bool consistent(const DicomPixels& p) {
  return p.bits_stored >= 1 && p.bits_stored <= p.bits_allocated && p.high_bit + 1 >= p.bits_stored &&
         p.high_bit < p.bits_allocated;
}

// Calls f(value), which gives the value of a stored word: HighBit and BitsStored say which bits of it that
// is.
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

// values of T from words of as many bytes, in place
template <class T>
void decode(std::span<T> values, const DicomPixels& p) {
  using Word = std::make_unsigned_t<T>;
  if (p.bits_stored == 8 * int(sizeof(T)) && !p.big_endian) return;  // they are that
  with_value(p, [&, turned = p.big_endian](const auto& value) {
    for (T& v : values) v = static_cast<T>(value(in_own_order(static_cast<Word>(v), turned)));
  });
}

// values of T from words of another length
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
    return failure(path, "is a damaged DICOM file: it has pixels, but no rows and columns");
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

template <class T>
Result<void> read_dicom_pixels(const DicomSlice& slice, std::span<T> to) {
  const auto width = static_cast<std::size_t>(slice.pixels.bits_allocated) / 8;
  if (slice.pixels.bits_allocated != 8 && slice.pixels.bits_allocated != 16 &&
      slice.pixels.bits_allocated != 32)
    return failure(slice.path, fmt::format("has pixels of {} bits; 8, 16 or 32 are read here",
                                           slice.pixels.bits_allocated));
  DicomPixels p = slice.pixels;
  if (!consistent(p))
    return failure(slice.path, fmt::format("is a damaged DICOM file: {} bits stored up to bit {} of {}",
                                           p.bits_stored, p.high_bit, p.bits_allocated));
  std::vector<std::byte> apart(width == sizeof(T) ? 0 : to.size() * width);
  const auto bytes = width == sizeof(T) ? std::as_writable_bytes(to) : std::span(apart);
  const auto read = p.fragments.empty() ? plain_bytes(slice, bytes) : unpacked_bytes(slice, bytes, p);
  if (!read) return read;
  if (!consistent(p)) return failure(slice.path, "has packed pixels that contradict themselves");

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

template Result<void> read_dicom_pixels(const DicomSlice&, std::span<std::int16_t>);
template Result<void> read_dicom_pixels(const DicomSlice&, std::span<std::int32_t>);

}  // namespace borelli
