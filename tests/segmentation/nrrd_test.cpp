// NRRD: headers written by hand after the format's definition, our own header read by hand, damage.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <random>
#include <sstream>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"

namespace borelli::nrrd_test {
namespace {

using Eigen::Vector3d;

const ReadOptions as_hu{FileQuantity::hu, {}};
const std::vector<std::int16_t> four{-1000, 0, 40, 3000};

std::vector<char> with_voxels(const std::string& header, const std::vector<std::int16_t>& voxels = four) {
  std::vector<char> bytes(header.begin(), header.end());
  const auto* first = reinterpret_cast<const char*>(voxels.data());
  bytes.insert(bytes.end(), first, first + 2 * voxels.size());
  return bytes;
}

std::string header(const std::string& more) {
  return "NRRD0004\n# by hand\ntype: short\ndimension: 3\nsizes: 2 2 1\nencoding: raw\nendian: little\n" +
         more + "\n";
}

const std::string lps =
    "space: left-posterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\n";

Result<ScannedVolume> read_text(const std::vector<char>& bytes) {
  ScratchFolder folder;
  put_bytes(folder / "a.nrrd", bytes);
  return read_volume(folder / "a.nrrd", as_hu);
}

// The file keeps shear: the vectors in our header, parsed here independently, equal the grid's axes bit for
// bit.
TEST(Nrrd, KeepsShearedGridsExactly) {
  ScratchFolder folder;
  const GreyVolume volume = noise_volume(oblique_grid(true, 1.5), Quantity::mr);
  ASSERT_TRUE(write_volume(folder / "a.nrrd", volume));
  const auto back = read_volume(folder / "a.nrrd");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->volume.grid, volume.grid);
  EXPECT_EQ(back->volume.voxels, volume.voxels);
  EXPECT_EQ(back->volume.quantity, Quantity::mr);

  const auto bytes = file_bytes(folder / "a.nrrd");
  const std::string text(bytes.begin(), bytes.end());
  std::string numbers = text.substr(text.find("space directions: ") + 18);
  numbers = numbers.substr(0, numbers.find('\n'));
  for (char& c : numbers)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::istringstream stream(numbers);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) {
      double value = 0;
      stream >> value;
      EXPECT_EQ(value, volume.grid.axes(r, c));
    }
  // the voxels are one gzip stream after the empty line
  const auto start = text.find("\n\n") + 2;
  std::vector<std::int16_t> voxels(volume.voxels.size());
  z_stream z{};
  ASSERT_EQ(inflateInit2(&z, 15 + 16), Z_OK);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + start));
  z.avail_in = static_cast<uInt>(bytes.size() - start);
  z.next_out = reinterpret_cast<Bytef*>(voxels.data());
  z.avail_out = static_cast<uInt>(2 * voxels.size());
  inflate(&z, Z_FINISH);
  inflateEnd(&z);
  EXPECT_EQ(voxels, volume.voxels);
}

TEST(Nrrd, ReadsSpacesUnitsAndSpacings) {
  const std::string vectors = "space directions: (2,0,0) (0,2,0) (0,0.5,3)\nspace origin: (1,2,3)\n";
  const auto in_lps = read_text(with_voxels(header("space: left-posterior-superior\n" + vectors)));
  const auto in_ras = read_text(with_voxels(header("space: RAS\n" + vectors)));
  const auto in_las = read_text(with_voxels(header("space: left-anterior-superior\n" + vectors)));
  const auto in_metres =
      read_text(with_voxels(header("space: LPS\nspace units: \"m\" \"m\" \"m\"\n" + vectors)));
  const auto unknown = read_text(with_voxels(header("spacings: 2 2 3\n")));
  ASSERT_TRUE(in_lps && in_ras && in_las && in_metres && unknown);
  EXPECT_EQ(in_lps->volume.grid.origin, Vector3d(1, 2, 3));
  EXPECT_EQ(in_lps->volume.grid.axes.col(2), Vector3d(0, 0.5, 3));
  EXPECT_EQ(in_ras->volume.grid.origin, Vector3d(-1, -2, 3));
  EXPECT_EQ(in_ras->volume.grid.axes.col(2), Vector3d(0, -0.5, 3));
  EXPECT_EQ(in_las->volume.grid.origin, Vector3d(1, -2, 3));
  EXPECT_EQ(in_metres->volume.grid.origin, Vector3d(1000, 2000, 3000));
  ASSERT_EQ(in_metres->warnings.size(), 1u);  // voxels of 2 m
  EXPECT_NE(in_metres->warnings[0].find("check the unit"), std::string::npos);
  EXPECT_EQ(unknown->volume.grid.spacing(), Vector3d(2, 2, 3));
  ASSERT_EQ(unknown->warnings.size(), 1u);
  EXPECT_NE(unknown->warnings[0].find("does not state the patient's orientation"), std::string::npos);
}

TEST(Nrrd, ReadsDetachedVoxelsWithLineAndByteSkip) {
  ScratchFolder folder;
  put_bytes(folder / "v.raw", with_voxels("a line\nanother\nxyz"));
  const auto text = [&](const std::string& skips) {
    const std::string h = header(lps + "data file: v.raw\n" + skips);
    put_bytes(folder / "a.nhdr", {h.begin(), h.end()});
    return read_volume(folder / "a.nhdr", as_hu);
  };
  const auto skipped = text("line skip: 2\nbyte skip: 3\n"), at_end = text("byte skip: -1\n");
  ASSERT_TRUE(skipped) << skipped.error().message();
  ASSERT_TRUE(at_end) << at_end.error().message();
  EXPECT_EQ(skipped->volume.voxels, four);
  EXPECT_EQ(at_end->volume.voxels, four);
}

TEST(Nrrd, IgnoresAnAxisOfOneSample) {
  std::string h =
      header("space: LPS\nspace directions: none (2,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\n");
  h.replace(h.find("dimension: 3"), 12, "dimension: 4"), h.replace(h.find("2 2 1"), 5, "1 2 2 1");
  EXPECT_FALSE(read_text(with_voxels(h))) << "two axes of one sample: which is the volume's?";
  h.replace(h.find("1 2 2 1"), 7, "1 2 1 2");
  EXPECT_FALSE(read_text(with_voxels(h)));
  h.replace(h.find("1 2 1 2"), 7, "1 2 2 2");
  auto eight = four;
  eight.insert(eight.end(), four.begin(), four.end());
  const auto read = read_text(with_voxels(h, eight));
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size, (std::array<std::int64_t, 3>{2, 2, 2}));
  EXPECT_EQ(read->volume.grid.spacing(), Vector3d(2, 2, 3));
}

TEST(Nrrd, RefusesDamageInOneSentence) {
  struct Case {
    std::string from, to, sentence;
  };
  const std::vector<Case> cases{
      {"NRRD0004", "NOPE0004", "not a NRRD file"},
      {"type: short", "type: block", "'block'"},
      {"dimension: 3", "dimension: 2", "disagree"},
      {"sizes: 2 2 1", "sizes: 2 2 0", "an axis has 0 voxels"},
      {"sizes: 2 2 1", "sizes: 2 -2 1", "an axis has -2 voxels"},
      {"sizes: 2 2 1", "sizes: 2 2 1e9", "an axis has 1000000000 voxels"},
      {"sizes: 2 2 1", "sizes: 90000 90000 90000", "cut off"},
      {"sizes: 2 2 1", "sizes: 2 2 9", "cut off"},
      {"encoding: raw", "encoding: hex", "'hex'"},
      {"encoding: raw", "encoding: gzip", "damaged compressed data"},
      {"endian: little", "endian: odd", "byte order"},
      {"endian: little", "endian: little\nSizes: 2 2 1", "'sizes' appears twice"},
      {"(0,0,3)", "(0,0)", "no vector of three numbers"},
      {"(0,0,3)", "(0,2,0)", "do not span a voxel"},
      {"(0,0,3)", "(0,0,nan)", "do not span a voxel"},
      {"space directions", "space nonsense", "does not state its voxel size"},
      {"space origin: (1,2,3)", "data file: slice%03d.raw 1 9 1", "has 1 slices, but its pattern"},
      {"encoding: raw", "encoding: ascii", "among its voxels; expected numbers of type int16"},
      {"encoding: raw", "encoding: bzip2", "does not contain bzip2 data"},
      {"space origin: (1,2,3)", "data file: absent.raw", "does not exist"},
      {"space origin: (1,2,3)", "byte skip: -7", "impossible"},
      {"dimension: 3\nsizes: 2 2 1", "dimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color domain domain domain",
       "colours or vectors"},
  };
  for (const auto& c : cases) {
    std::string h = header(lps);
    h.replace(h.find(c.from), c.from.size(), c.to);
    const auto read = read_text(with_voxels(h));
    ASSERT_FALSE(read) << c.to;
    EXPECT_NE(read.error().message().find(c.sentence), std::string::npos)
        << c.to << ": " << read.error().message();
  }
}

TEST(Nrrd, FlippedHeaderBytesNeverCrash) {
  ScratchFolder folder;
  const std::string h = header(lps + "byte skip: 0\n");
  std::mt19937 random(13);
  int refused = 0;
  for (int round = 0; round < 500; ++round) {
    auto bytes = with_voxels(h);
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      bytes[random() % h.size()] = static_cast<char>(random());
    put_bytes(folder / "a.nrrd", bytes);
    const auto read = read_volume(folder / "a.nrrd", as_hu);
    if (!read) ++refused;
  }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace borelli::nrrd_test
