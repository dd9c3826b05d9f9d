// Folders of DICOM slices: plain, packed by every codec that GDCM can write, deflated, multi-frame.
#include <fmt/format.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmTrace.h>
#include <unistd.h>
#include <zlib.h>

#include "tests/mutation/dicom_bytes.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_dicom {

namespace fs = std::filesystem;

struct Size {
  int columns = 6, rows = 4;
};
const std::string ct = "1.2.840.10008.5.1.4.1.1.2", deflated = "1.2.840.10008.1.2.1.99",
                  rle = "1.2.840.10008.1.2.5";

std::vector<std::uint16_t> pixels_of(int slice, Size size = {}) {
  std::vector<std::uint16_t> out;
  for (int n = 0; n < size.columns * size.rows; ++n)
    out.push_back(static_cast<std::uint16_t>(n % 5 < 2 ? 24 : 1000 + 40 * slice + n));
  return out;
}

std::string raw_bytes(const std::vector<std::uint16_t>& pixels) {
  return {reinterpret_cast<const char*>(pixels.data()), 2 * pixels.size()};
}

// All elements of a slice before its pixels.
DataSet slice_header(int slice, Size size = {}) {
  DataSet d;
  d.add(0x00080008, "CS", "ORIGINAL\\PRIMARY\\AXIAL").add(0x00080016, "UI", ct);
  d.add(0x00080018, "UI", fmt::format("1.2.3.4.{}", slice + 1)).add(0x00080060, "CS", "CT");
  d.add(0x0008103e, "LO", "body").add(0x00180050, "DS", "2.5").add(0x00185100, "CS", "HFS");
  d.add(0x0020000e, "UI", "1.2.3").add(0x00200012, "IS", "1");
  d.add(0x00200032, "DS", fmt::format("-10\\-20\\{:.1f}", 30 + 2.5 * slice));
  d.add(0x00200037, "DS", "1\\0\\0\\0\\1\\0").number(0x00280002, 1).add(0x00280004, "CS", "MONOCHROME2");
  d.number(0x00280010, static_cast<std::uint16_t>(size.rows));
  d.number(0x00280011, static_cast<std::uint16_t>(size.columns)).add(0x00280030, "DS", "0.5\\0.75");
  d.number(0x00280100, 16).number(0x00280101, 16).number(0x00280102, 15).number(0x00280103, 0);
  d.number(0x00280120, 0)
      .add(0x00281052, "DS", "-1024")
      .add(0x00281053, "DS", "1")
      .add(0x00281054, "LO", "HU");
  return d;
}

std::string plain_slice_of(int slice, Size size) {
  DataSet d = slice_header(slice, size);
  d.add(0x7fe00010, "OW", raw_bytes(pixels_of(slice, size)));
  return dicom_head(ct, plain_syntax) + d.bytes;
}
std::string plain_slice(int slice) { return plain_slice_of(slice, {}); }

// PackBits (PS3.5, G.3): runs of equal bytes, and of unequal ones.
std::string packed_bits(const std::string& bytes) {
  std::string out;
  for (std::size_t n = 0; n < bytes.size();) {
    std::size_t same = 1;
    while (n + same < bytes.size() && bytes[n + same] == bytes[n] && same < 128) ++same;
    if (same > 1) {
      out += static_cast<char>(257 - same);
      out += bytes[n];
    } else {
      out += '\0';
      out += bytes[n];
    }
    n += same;
  }
  return out.size() % 2 ? out + '\x80' : out;
}

// Two segments, the high bytes first (PS3.5, G.2 and G.5).
std::string rle_slice(int slice) {
  std::string high, low;
  for (const auto pixel : pixels_of(slice))
    high += static_cast<char>(pixel >> 8), low += static_cast<char>(pixel);
  high = packed_bits(high), low = packed_bits(low);
  std::string frame = little_endian<std::uint32_t>(2) + little_endian<std::uint32_t>(64) +
                      little_endian(static_cast<std::uint32_t>(64 + high.size()));
  frame.resize(64, '\0');
  DataSet d = slice_header(slice);
  d.packed_pixels({frame + high + low});
  return dicom_head(ct, rle) + d.bytes;
}

// All after the meta information is one raw deflate stream (PS3.5, A.5).
std::string deflated_slice(const std::string& data_set) {
  std::string out(data_set.size() + 1000, '\0');
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data_set.data()));
  z.avail_in = static_cast<uInt>(data_set.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return dicom_head(ct, deflated) + out;
}

// The slices packed by a codec of GDCM; no files where it lacks the codec. Its JPEG 2000 crashes below 32
// x 32.
TestCase packed_by_gdcm(const std::string& name, gdcm::TransferSyntax::TSType syntax) {
  gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff();
  TestCase test{name, {}};
  const fs::path plain = fs::temp_directory_path() / fmt::format("borelli-plain-{}.dcm", getpid()),
                 packed = fs::temp_directory_path() / fmt::format("borelli-packed-{}.dcm", getpid());
  for (int slice = 0; slice < 2; ++slice) {
    write_case({"", {{plain.filename().string(), plain_slice_of(slice, {32, 32})}}}, plain.string() + ".d");
    gdcm::ImageReader reader;
    reader.SetFileName((fs::path(plain.string() + ".d") / plain.filename()).c_str());
    gdcm::ImageChangeTransferSyntax change;
    change.SetTransferSyntax(syntax);
    if (!reader.Read()) break;
    change.SetInput(reader.GetImage());
    if (!change.Change()) break;
    gdcm::ImageWriter writer;
    writer.SetFile(reader.GetFile());
    writer.SetImage(change.GetOutput());
    writer.SetFileName(packed.c_str());
    if (!writer.Write()) break;
    test.files.push_back({fmt::format("slice{}.dcm", slice), bytes_of(packed)});
  }
  std::error_code ignored;
  fs::remove_all(plain.string() + ".d", ignored), fs::remove(packed, ignored);
  return test;
}

DataSet frame_place(double z, bool undefined) {
  DataSet at;
  at.add(0x00200032, "DS", fmt::format("-10\\-20\\{:.1f}", z));
  return DataSet().sequence(0x00209113, {at}, undefined);
}

std::string multi_frame(bool undefined) {
  DataSet direction, measures, scaling, shared;
  direction.add(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
  measures.add(0x00180050, "DS", "2.5").add(0x00280030, "DS", "0.5\\0.75");
  scaling.add(0x00281052, "DS", "-1024").add(0x00281053, "DS", "1").add(0x00281054, "LO", "HU");
  shared.sequence(0x00209116, {direction}, undefined)
      .sequence(0x00289110, {measures}, undefined)
      .sequence(0x00289145, {scaling}, undefined);
  std::vector<DataSet> frames;
  std::string pixels;
  for (int n = 0; n < 3; ++n)
    frames.push_back(frame_place(30 + 2.5 * n, undefined)), pixels += raw_bytes(pixels_of(n));
  DataSet d;
  const std::string enhanced = "1.2.840.10008.5.1.4.1.1.2.1";
  d.add(0x00080016, "UI", enhanced).add(0x00080018, "UI", "1.2.3.4").add(0x00080060, "CS", "CT");
  d.add(0x0020000e, "UI", "1.2.3").number(0x00280002, 1).add(0x00280004, "CS", "MONOCHROME2");
  d.add(0x00280008, "IS", "3").number(0x00280010, 4).number(0x00280011, 6);
  d.number(0x00280100, 16).number(0x00280101, 16).number(0x00280102, 15).number(0x00280103, 0);
  d.sequence(0x52009229, {shared}, undefined).sequence(0x52009230, frames, undefined);
  d.add(0x7fe00010, "OW", pixels);
  return dicom_head(enhanced, plain_syntax) + d.bytes;
}

TestCase folder_of(const std::string& name, std::string (*slice)(int)) {
  TestCase test{name, {}};
  for (int n = 0; n < 3; ++n) test.files.push_back({fmt::format("slice{}.dcm", n), slice(n)});
  return test;
}

std::vector<TestCase> seeds() {
  std::vector<TestCase> out{folder_of("plain", plain_slice), folder_of("rle", rle_slice)};
  // mutations reach the bytes before deflation
  TestCase stream{"deflated", {}, true};
  for (int n = 0; n < 3; ++n) {
    DataSet d = slice_header(n);
    d.add(0x7fe00010, "OW", raw_bytes(pixels_of(n)));
    stream.files.push_back({fmt::format("slice{}.dcm", n), d.bytes, deflated_slice});
  }
  out.push_back(stream);
  for (const bool undefined : {false, true})
    out.push_back({undefined ? "frames_undefined" : "frames", {{"frames.dcm", multi_frame(undefined)}}});
  using Syntax = gdcm::TransferSyntax;
  for (const auto& [name, syntax] : {std::pair{"jpeg", Syntax::JPEGLosslessProcess14_1},
                                     {"jpeg_ls", Syntax::JPEGLSLossless},
                                     {"jpeg_2000", Syntax::JPEG2000Lossless}})
    if (TestCase test = packed_by_gdcm(name, syntax); !test.files.empty()) out.push_back(test);
  return out;
}

}  // namespace of_dicom

Reader dicom_reader() {
  return {"dicom", of_dicom::seeds, [](const fs::path& file) { return try_volume(file.parent_path()); }};
}

}  // namespace borelli::mutation
