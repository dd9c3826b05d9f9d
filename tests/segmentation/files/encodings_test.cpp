// Encodings of voxels (text, bzip2, lists of files) and decompression bombs.
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>

#include "process/memory.hpp"
#include "segmentation/files/read.hpp"
#include "tests/segmentation/grids.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli::encodings_test {
namespace {

const ReadOptions as_hu{FileQuantity::hu, {}};

void put_text(const std::string& path, const std::string& text) {
  put_bytes(path, {text.begin(), text.end()});
}

std::string nrrd_header(const std::string& type, const std::string& more) {
  return "NRRD0004\ntype: " + type +
         "\ndimension: 3\nspace: LPS\nsizes: 5 7 4\nspace directions: (2,0,0) (0,2,0) (0,0,3)\n"
         "endian: little\n" +
         more;
}

GreyVolume noise() {
  Grid grid;
  grid.size = {5, 7, 4};
  return noise_volume(grid, Quantity::hu);
}

std::vector<char> raw_bytes(const GreyVolume& volume) {
  const auto* const first = reinterpret_cast<const char*>(volume.voxels.data());
  return {first, first + 2 * volume.voxels.size()};
}

std::string refusal(const std::string& path) {
  const auto read = read_volume(path, as_hu);
  return read ? "was read" : read.error().message();
}

TEST(TextVoxels, ReadsEveryTypeWithBlanksAndCommasBetweenNumbers) {
  ScratchFolder folder;
  const GreyVolume volume = noise();
  std::string text;
  for (std::size_t n = 0; n < volume.voxels.size(); ++n) {
    text += std::to_string(volume.voxels[n]);
    text += n % 5 == 4 ? "\r\n" : n % 3 == 0 ? ", " : "\t";
  }
  for (const char* type : {"short", "int", "longlong", "float", "double"}) {
    put_text(folder / "a.nrrd", nrrd_header(type, "encoding: ascii\n\n") + text);
    const auto read = read_volume(folder / "a.nrrd", as_hu);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->volume.voxels, volume.voxels) << type;
  }
  put_text(folder / "v.txt", "a line before them\n" + text);
  put_text(folder / "a.nhdr", nrrd_header("short", "encoding: text\nline skip: 1\ndata file: v.txt\n"));
  const auto detached = read_volume(folder / "a.nhdr", as_hu);
  ASSERT_TRUE(detached) << detached.error().message();
  EXPECT_EQ(detached->volume.voxels, volume.voxels);
}

// Taken for separators, decimal commas would make two voxels of one number.
TEST(TextVoxels, RefusesDecimalCommasAndLeftOverNumbers) {
  ScratchFolder folder;
  std::string fine;
  for (int n = 0; n < 140; ++n) fine += fmt::format("{} ", n);
  const auto told = [&](const std::string& text) {
    put_text(folder / "a.nrrd", nrrd_header("float", "encoding: ascii\n\n") + text);
    return refusal(folder / "a.nrrd");
  };
  EXPECT_EQ(told(fine + " \n"), "was read");
  EXPECT_NE(told("-1000,3 " + fine.substr(2)).find("has '-1000,3' among its voxels"), std::string::npos);
  EXPECT_NE(told(fine + "7").find("contains more numbers than the voxels that its header states"),
            std::string::npos)
      << told(fine + "7");
}

// Several blocks of the reader, so that numbers cross block borders.
TEST(TextVoxels, KeepsDigitsAcrossBlocks) {
  ScratchFolder folder;
  std::string text;
  std::vector<std::int16_t> expected;
  for (int n = 0; n < 200 * 200; ++n) {
    expected.push_back(static_cast<std::int16_t>(n % 2000 - 1000));
    text += std::to_string(expected.back()) + "          ";
  }
  std::string header = nrrd_header("short", "encoding: ascii\n\n");
  header.replace(header.find("5 7 4"), 5, "200 200 1");
  put_text(folder / "a.nrrd", header + text);
  const auto read = read_volume(folder / "a.nrrd", as_hu);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.voxels, expected);
}

TEST(TextVoxels, NamesValuesOutsideTheType) {
  ScratchFolder folder;
  std::string fine;
  for (int n = 0; n < 139; ++n) fine += "7 ";
  const auto told = [&](const std::string& type, const std::string& last) {
    put_text(folder / "a.nrrd", nrrd_header(type, "encoding: ascii\n\n") + fine + last);
    return refusal(folder / "a.nrrd");
  };
  EXPECT_EQ(told("uchar", "7").find("was read"), 0U);
  for (const auto& [type, last] :
       {std::pair{"uchar", "256"}, {"uchar", "-1"}, {"short", "1.5"}, {"float", "x"}})
    EXPECT_NE(told(type, last).find("has '" + std::string(last) + "' among its voxels"), std::string::npos)
        << told(type, last);
  EXPECT_NE(told("short", std::string(100000, '9')).find("among its voxels"), std::string::npos);
  EXPECT_NE(told("short", "").find("is cut off: it has 278 of 280 bytes"), std::string::npos)
      << told("short", "");
}

class Bzip2 : public ::testing::Test {
 protected:
  // the bytes packed by Python's bz2
  std::vector<char> packed(const std::vector<char>& bytes) const {
    put_bytes(folder / "plain", bytes);
    const std::string command =
        "/usr/bin/python3 -c 'import bz2, sys; open(sys.argv[2], \"wb\").write("
        "bz2.compress(open(sys.argv[1], \"rb\").read()))' " +
        folder / "plain" + " " + folder / "packed";
    return std::system(command.c_str()) == 0 ? file_bytes(folder / "packed") : std::vector<char>{};
  }
  ScratchFolder folder;
};

TEST_F(Bzip2, ReadsAttachedDetachedAndSeveralStreams) {
  const GreyVolume volume = noise();
  const auto raw = raw_bytes(volume);
  const auto whole = packed(raw);
  if (whole.empty()) GTEST_SKIP() << "needs python3";
  std::vector<char> two = packed({raw.begin(), raw.begin() + 101});
  const auto rest = packed({raw.begin() + 101, raw.end()});
  two.insert(two.end(), rest.begin(), rest.end());
  put_bytes(folder / "v.bz2", two);
  put_text(folder / "a.nhdr", nrrd_header("short", "encoding: bz2\ndata file: v.bz2\n"));
  const auto header = nrrd_header("short", "encoding: bzip2\n\n");
  const auto attached = [&](const std::vector<char>& bytes) {
    std::vector<char> all(header.begin(), header.end());
    all.insert(all.end(), bytes.begin(), bytes.end());
    put_bytes(folder / "a.nrrd", all);
    return folder / "a.nrrd";
  };
  for (const std::string& path : {attached(whole), folder / "a.nhdr"}) {
    const auto read = read_volume(path, as_hu);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->volume.voxels, volume.voxels);
  }
  const auto cut = refusal(attached({whole.begin(), whole.end() - 5}));
  EXPECT_NE(cut.find("cut off"), std::string::npos) << cut;
  auto flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(~flipped[whole.size() / 2]);
  const auto damaged = refusal(attached(flipped));
  EXPECT_NE(damaged.find("damaged compressed data"), std::string::npos) << damaged;
}

TEST(SliceLists, NrrdNamesItsFilesByListOrNumber) {
  ScratchFolder folder;
  const GreyVolume volume = noise();
  const auto raw = raw_bytes(volume);
  const std::size_t half = raw.size() / 2, slice = raw.size() / 4;
  for (std::size_t k = 0; k < 4; ++k) {
    std::vector<char> bytes{'x', 'y', 'z'};
    bytes.insert(bytes.end(), raw.begin() + static_cast<long>(k * slice),
                 raw.begin() + static_cast<long>((k + 1) * slice));
    put_bytes(folder / ("s" + std::to_string(9 - k) + ".raw"), bytes);
  }
  put_bytes(folder / "low.raw", {raw.begin(), raw.begin() + static_cast<long>(half)});
  put_bytes(folder / "high half.raw", {raw.begin() + static_cast<long>(half), raw.end()});
  for (const char* more : {"encoding: raw\nbyte skip: 3\ndata file: s%d.raw 9 6 -1\n",
                           "encoding: raw\nbyte skip: -1\ndata file: LIST\ns9.raw\ns8.raw\ns7.raw\ns6.raw\n",
                           "encoding: raw\ndata file: LIST 3\nlow.raw\nhigh half.raw\n"}) {
    put_text(folder / "a.nhdr", nrrd_header("short", more));
    const auto read = read_volume(folder / "a.nhdr", as_hu);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->volume.voxels, volume.voxels) << more;
  }
  put_text(folder / "a.nhdr",
           nrrd_header("short", "encoding: raw\ndata file: LIST\nlow.raw\ns9.raw\nlow.raw\n"));
  EXPECT_NE(refusal(folder / "a.nhdr").find("names 3 files for 4 slices"), std::string::npos)
      << refusal(folder / "a.nhdr");
  put_text(folder / "a.nhdr", nrrd_header("short", "encoding: raw\ndata file: LIST\nlow.raw\ns9.raw\n"));
  EXPECT_NE(refusal(folder / "a.nhdr").find("s9.raw: is cut off"), std::string::npos)
      << refusal(folder / "a.nhdr");
}

// this many MiB of zeros as gzip
std::vector<char> gzip_zeros(std::size_t megabytes) {
  std::vector<unsigned char> zeros(std::size_t{1} << 20, 0), out(megabytes * 10000 + 1000);
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 1, Z_DEFLATED, 31, 9, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_out = out.data(), stream.avail_out = static_cast<uInt>(out.size());
  for (std::size_t n = 0; n < megabytes; ++n) {
    stream.next_in = zeros.data(), stream.avail_in = static_cast<uInt>(zeros.size());
    deflate(&stream, n + 1 < megabytes ? Z_NO_FLUSH : Z_FINISH);
  }
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return {out.begin(), out.end()};
}

TEST(Bombs, AreRefusedBeforeMemoryOrTimeIsSpent) {
  ScratchFolder folder;
  const std::uint64_t before = memory_limit();
  set_memory_limit(std::uint64_t{200} << 20);
  // a true header whose volume is too large
  const auto packed = gzip_zeros(256);
  EXPECT_LT(packed.size(), std::size_t{2} << 20);
  std::string header = nrrd_header("short", "encoding: gzip\n\n");
  header.replace(header.find("5 7 4"), 5, "1024 1024 128");
  std::vector<char> bytes(header.begin(), header.end());
  bytes.insert(bytes.end(), packed.begin(), packed.end());
  put_bytes(folder / "large.nrrd", bytes);
  const auto large = refusal(folder / "large.nrrd");
  EXPECT_NE(large.find("its volume of 1024 x 1024 x 128 voxels of int16 needs 268 MB of memory"),
            std::string::npos)
      << large;
  EXPECT_NE(large.find("--max-memory"), std::string::npos) << large;
  // a header of a small volume: the reader stops early in the long stream
  header = nrrd_header("short", "encoding: gzip\n\n");
  bytes.assign(header.begin(), header.end());
  bytes.insert(bytes.end(), packed.begin(), packed.end());
  put_bytes(folder / "small.nrrd", bytes);
  const auto small = refusal(folder / "small.nrrd");
  EXPECT_NE(small.find("more than twice the 280 bytes of voxels"), std::string::npos) << small;
  set_memory_limit(before);
}

}  // namespace
}  // namespace borelli::encodings_test
