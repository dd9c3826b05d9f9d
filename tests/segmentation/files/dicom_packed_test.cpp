// Compressed pixels of DICOM: RLE streams made by hand (PS3.5, annex G), damaged codec streams, deflated data
// sets.
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zlib.h>

#include <chrono>
#include <cstdlib>
#include <random>

#include "segmentation/files/dicom_rle.hpp"
#include "segmentation/files/read.hpp"
#include "tests/paths.hpp"
#include "tests/segmentation/dicom_series.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli {
namespace dicom_packed_test {
namespace {

std::string words(const std::vector<std::uint32_t>& values) {
  std::string bytes;
  for (const std::uint32_t v : values)
    for (int n = 0; n < 4; ++n) bytes += static_cast<char>(v >> 8 * n);
  return bytes;
}
// the header of a stream whose segments start at these offsets
std::string rle_header(std::vector<std::uint32_t> starts) {
  const auto count = static_cast<std::uint32_t>(starts.size());
  starts.insert(starts.begin(), count);
  starts.resize(16, 0);
  return words(starts);
}
std::string unpacked(const std::string& stream, std::size_t width, std::size_t pixels) {
  std::string to(width * pixels, '\0');
  EXPECT_EQ(unpack_rle(std::as_bytes(std::span(stream)), width, std::as_writable_bytes(std::span(to))), "");
  return to;
}
std::string refusal(const std::string& stream, std::size_t width, std::size_t pixels) {
  std::string to(width * pixels, '\0');
  return std::string(
      unpack_rle(std::as_bytes(std::span(stream)), width, std::as_writable_bytes(std::span(to))));
}

TEST(DicomRle, DecodesRunsAndLiterals) {
  // three literals, a no-op, 'z' five times, two literals
  const std::string segment = "\2abc\x80\xFCz\1xy";
  EXPECT_EQ(unpacked(rle_header({64}) + segment, 1, 10), "abczzzzzxy");
  EXPECT_EQ(unpacked(rle_header({64}) + segment + '\0', 1, 10), "abczzzzzxy");  // padded
  // the most significant byte comes first
  EXPECT_EQ(unpacked(rle_header({64, 66}) + "\xFEH\2abc", 2, 3), "aHbHcH");
  EXPECT_EQ(unpacked(rle_header({64, 68, 70}) + "\2ABC\xFEy\xFEz", 3, 3), "zyAzyBzyC");
  // the longest run and the longest literal
  const std::string long_run = std::string("\x81q") + '\x7f' + std::string(128, 'r');
  EXPECT_EQ(unpacked(rle_header({64}) + long_run, 1, 256), std::string(128, 'q') + std::string(128, 'r'));
}

TEST(DicomRle, RefusesDamagedStreams) {
  const std::string whole = rle_header({64, 66}) + "\xFEH\2abc";
  ASSERT_EQ(unpacked(whole, 2, 3), "aHbHcH");
  for (std::size_t cut = 0; cut < whole.size(); ++cut)
    EXPECT_NE(refusal(whole.substr(0, cut), 2, 3), "") << cut;
  for (const auto& starts : std::vector<std::vector<std::uint32_t>>{
           {}, {64}, {64, 66, 67}, {0, 66}, {66, 64}, {64, 0xffffffff}, {0xffffffff, 66}, {64, 71}})
    EXPECT_NE(refusal(rle_header(starts) + "\xFEH\2abc", 2, 3), "");
  EXPECT_NE(refusal(whole, 2, 4), "");                                            // too few pixels
  EXPECT_EQ(refusal(whole, 2, 2), "a segment does not hold one byte per pixel");  // too many
  std::mt19937 random(5);
  for (int round = 0; round < 20000; ++round) {
    std::string bytes = whole;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    refusal(bytes, 2, 3);  // must end within its bounds, which a sanitizer checks
  }
}

void write_packed(const std::string& path, int k, gdcm::TransferSyntax::TSType syntax) {
  TestSlice slice;
  slice.columns = 16, slice.rows = 12;
  slice.position.z() = 2 * k;
  slice.instance = "1.2.3.1." + std::to_string(k + 1);
  for (int n = 0; n < 16 * 12; ++n)
    slice.pixels.push_back(static_cast<std::uint16_t>(1000 + (7 * n * n + k) % 640));
  write_slice(path, slice);
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  ASSERT_TRUE(reader.Read());
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(syntax);
  change.SetInput(reader.GetImage());
  ASSERT_TRUE(change.Change());
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  writer.SetFileName(path.c_str());
  ASSERT_TRUE(writer.Write());
}

constexpr std::array syntaxes{gdcm::TransferSyntax::RLELossless,
                              gdcm::TransferSyntax::JPEGLosslessProcess14_1,
                              gdcm::TransferSyntax::JPEGLSLossless, gdcm::TransferSyntax::JPEG2000Lossless};

TEST(DicomPacked, EverySyntaxGivesTheSamePixels) {
  for (const auto syntax : syntaxes) {
    const ScratchFolder folder;
    for (int k = 0; k < 3; ++k) write_packed(folder / std::to_string(k), k, syntax);
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    for (int k = 0; k < 3; ++k)
      for (int n = 0; n < 16 * 12; ++n)
        ASSERT_EQ(read->volume.voxels[static_cast<std::size_t>(16 * 12 * k + n)],
                  1000 + (7 * n * n + k) % 640 - 1024);
  }
}

// Codecs of libraries run in a child process that decodes several slices; RLE needs none.
TEST(DicomPacked, CodecsRunInTheirOwnProcess) {
  const auto children = [](gdcm::TransferSyntax::TSType syntax) {
    const ScratchFolder folder;
    for (int k = 0; k < 40; ++k) write_packed(folder / std::to_string(k), k, syntax);
    rusage before{}, after{};
    getrusage(RUSAGE_CHILDREN, &before);
    EXPECT_TRUE(read_volume(folder.path()));
    getrusage(RUSAGE_CHILDREN, &after);
    return after.ru_minflt - before.ru_minflt;
  };
  EXPECT_GT(children(gdcm::TransferSyntax::JPEGLSLossless), 0);
  EXPECT_EQ(children(gdcm::TransferSyntax::RLELossless), 0);
}

// Random bytes in the second half of the file, which holds the pixels.
TEST(DicomPacked, DamagedPixelsNeverEndTheProgram) {
  std::mt19937 random(7);
  for (const auto syntax : syntaxes) {
    const ScratchFolder folder;
    for (int k = 0; k < 3; ++k) write_packed(folder / std::to_string(k), k, syntax);
    const std::string victim = folder / "1";
    const auto whole = file_bytes(victim);
    for (int round = 0; round < 60; ++round) {
      auto bytes = whole;
      const std::size_t pixels = whole.size() / 2;
      for (unsigned flips = 1 + random() % 6; flips > 0; --flips)
        bytes[pixels + random() % (bytes.size() - pixels)] = static_cast<char>(random());
      put_bytes(victim, bytes);
      if (const auto read = read_volume(folder.path()); !read) {
        EXPECT_NE(read.error().what, "") << round;
      }
    }
  }
}

TEST(DicomPacked, RefusesRleWithoutSegments) {
  const std::string path = test::shared_folder() + "/cases/rle_sigfpe";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the case is not there: " << path;
  const auto read = read_volume(path);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, Error::Kind::failure);
  EXPECT_NE(read.error().message().find("s0.dcm: contains damaged pixels (RLE"), std::string::npos)
      << read.error().message();
}

// Writes these bytes as a deflated data set (PS3.5, A.5).
void write_deflated(const std::string& path, const std::string& data_set) {
  std::string packed(compressBound(static_cast<uLong>(data_set.size())) + 64, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -15, 9, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data_set.data()));
  stream.avail_in = static_cast<uInt>(data_set.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data()),
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  const std::string syntax = "1.2.840.10008.1.2.1.99";
  std::ofstream(path, std::ios::binary) << std::string(128, '\0') << "DICM" << std::string("\2\0\x10\0UI", 6)
                                        << static_cast<char>(syntax.size()) << '\0' << syntax << packed;
}

// A plain file without its preamble and group 2. GDCM writes the length of group 2 first.
std::string data_set_of(const std::string& path) {
  const auto bytes = file_bytes(path);
  const std::string text(bytes.begin(), bytes.end());
  std::uint32_t meta = 0;
  std::memcpy(&meta, text.data() + 140, sizeof meta);
  return text.substr(144 + meta);
}

TEST(DicomPacked, ReadsDeflatedDataSets) {
  const ScratchFolder plain, folder;
  for (int k = 0; k < 3; ++k) {
    TestSlice slice;
    slice.position.z() = 2 * k;
    slice.instance = "1.2.3.1." + std::to_string(k + 1);
    for (int n = 0; n < 30; ++n) slice.pixels.push_back(static_cast<std::uint16_t>(1000 + 50 * k + n));
    write_slice(plain / std::to_string(k), slice);
    write_deflated(folder / std::to_string(k), data_set_of(plain / std::to_string(k)));
  }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  for (int k = 0; k < 3; ++k)
    for (int n = 0; n < 30; ++n)
      EXPECT_EQ(read->volume.voxels[static_cast<std::size_t>(30 * k + n)], 50 * k + n - 24);

  const auto whole = file_bytes(folder / "1");
  for (std::size_t cut = 170; cut + 8 < whole.size(); cut += 3) {
    auto bytes = whole;
    bytes.resize(cut);
    put_bytes(folder / "1", bytes);
    EXPECT_FALSE(read_volume(folder.path())) << cut;
  }
}

// 100 kB that inflate to a useless value of 100 MB.
TEST(DicomPacked, RefusesDecompressionBombs) {
  const ScratchFolder folder;
  const std::uint32_t length = 100'000'000;
  write_deflated(folder / "0",
                 std::string("\x09\0\x10\0UN\0\0", 8) + words({length}) + std::string(length, '\0'));
  const auto start = std::chrono::steady_clock::now();
  const auto read = read_volume(folder.path());
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("cut off or damaged"), std::string::npos) << read.error().message();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

}  // namespace
}  // namespace dicom_packed_test
}  // namespace borelli
