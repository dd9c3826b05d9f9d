// MetaImage: headers written by hand after MetaIO's description, and damage that would abort MetaIO itself.
#include <gtest/gtest.h>

#include <random>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

const ReadOptions as_hu{FileQuantity::hu, {}};
const std::vector<std::int16_t> four{-1000, 0, 40, 3000};

const std::string header =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nTransformMatrix = 0 1 "
    "0 -1 0 0 0 0 1\n"
    "Offset = 1 2 3\nAnatomicalOrientation = RAI\nElementSpacing = 2 2.5 3\nDimSize = 2 2 1\nElementType = "
    "MET_SHORT\n"
    "ElementDataFile = LOCAL\n";

std::vector<char> with_voxels(const std::string& text) {
  std::vector<char> bytes(text.begin(), text.end());
  const auto* first = reinterpret_cast<const char*>(four.data());
  bytes.insert(bytes.end(), first, first + 8);
  return bytes;
}

Result<ScannedVolume> read_changed(const std::string& from, const std::string& to) {
  ScratchFolder folder;
  std::string text = header;
  text.replace(text.find(from), from.size(), to);
  put_bytes(folder / "a.mha", with_voxels(text));
  return read_volume(folder / "a.mha", as_hu);
}

TEST(MetaImage, PlacesVoxelsByItsMatrix) {
  const auto read = read_changed("", "");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.voxels, four);
  EXPECT_EQ(read->volume.grid.point({1, 0, 0}), Vector3d(1, 4, 3));     // axis 0 runs along y
  EXPECT_EQ(read->volume.grid.point({0, 1, 0}), Vector3d(-1.5, 2, 3));  // axis 1 against x
}

TEST(MetaImage, ScalesByItsHeader) {
  const auto read = read_changed(
      "ElementSpacing",
      "ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = 10\nElementSpacing");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.voxels, (std::vector<std::int16_t>{padding_hu, 10, 90, 6010}));  // -1990
}

TEST(MetaImage, RoundTripsExactlyAndRefusesShear) {
  ScratchFolder folder;
  const GreyVolume volume = noise_volume(oblique_grid(true, 0), Quantity::density_kgm3);
  ASSERT_TRUE(write_volume(folder / "a.mha", volume));
  auto dense = volume;  // densities must not be negative
  for (auto& v : dense.voxels) v = static_cast<std::int16_t>(v + 1024);
  ASSERT_TRUE(write_volume(folder / "a.mha", dense));
  const auto back = read_volume(folder / "a.mha");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->volume.voxels, dense.voxels);
  EXPECT_EQ(back->volume.quantity, Quantity::density_kgm3);
  // cosines and spacings are stored as doubles; their products round once more
  EXPECT_LT((back->volume.grid.axes - volume.grid.axes).cwiseAbs().maxCoeff(), 1e-14);

  const auto refused = write_volume(folder / "b.mha", noise_volume(oblique_grid(false, 0.3), Quantity::hu));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("sheared"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "b.mha"));
}

TEST(MetaImage, RefusesDamageInOneSentence) {
  struct Case {
    std::string from, to, sentence;
  };
  const std::vector<Case> cases{
      {"NDims = 3", "NDims = 4", "disagree"},
      {"NDims = 3", "NDims = 99999999", "disagree"},
      {"NDims = 3\n", "", "not a MetaImage"},
      {"DimSize = 2 2 1", "DimSize = 2 2", "disagree"},
      {"DimSize = 2 2 1", "DimSize = 2 -2 1", "an axis has -2"},
      {"DimSize = 2 2 1", "DimSize = 99999 99999 99999", "cut off"},
      {"DimSize = 2 2 1", "DimSize = 2 2 2", "cut off"},
      {"NDims = 3", "NDims = 2", "disagree"},
      {"MET_SHORT", "MET_STRING", "'MET_STRING'"},
      {"MET_SHORT", "", "''"},
      {"BinaryData = True", "BinaryData = False", "among its voxels; expected numbers of type int16"},
      {"BinaryData = True", "CompressedData = True", "damaged compressed data"},
      {"ElementSpacing = 2 2.5 3", "ElementSpacing = 2",
       "ElementSpacing is '2'; expected 3 numbers separated by blanks"},
      {"ElementSpacing = 2 2.5 3", "ElementSpacing = 2 0 3", "do not span a voxel"},
      {"0 1 0 -1 0 0 0 0 1", "0 1 0 0 1 0 0 0 1", "do not span a voxel"},
      {"0 1 0 -1 0 0 0 0 1", "1 0 0", "TransformMatrix is '1 0 0'; expected 9 numbers"},
      {"LOCAL", "LIST\na.raw\nb.raw", "for 1 slices"},
      {"LOCAL", "slice%03d.raw 1 9 1", "has 1 slices, but its pattern"},
      {"LOCAL", "slice%n.raw 1 1 1", "expected one like 'slice%03d.raw 1 1 1'"},
      {"LOCAL", "slice%d%d.raw 1 1 1", "expected one like"},
      {"LOCAL", "slice%9999999d.raw 1 1 1", "expected one like"},
      {"LOCAL", "slice%d.raw 1 1 1", "slice1.raw', which does not exist"},
      {"LOCAL", "absent.raw", "does not exist"},
      {"ElementDataFile = LOCAL", "", "no ElementDataFile"},
      {"ElementType", "ElementNumberOfChannels = 3\nElementType", "3 values per voxel"},
      {"ElementType", "ElementToIntensityFunctionSlope = abc\nElementType",
       "slope or intercept is not a number"},
      {"ElementType", "ElementToIntensityFunctionSlope = 2x\nElementType",
       "slope or intercept is not a number"},
      {"ElementType", "ElementToIntensityFunctionSlope = 0\nElementType",
       "slope or intercept is not a number"},
      {"ElementType", "ElementToIntensityFunctionOffset = 1e999\nElementType",
       "slope or intercept is not a number"},
      {"ElementSpacing = 2 2.5 3", "ElementSpacing = 2 2.5 1e8", "check the unit"},
  };
  for (const auto& c : cases) {
    const auto read = read_changed(c.from, c.to);
    ASSERT_FALSE(read) << c.to;
    EXPECT_NE(read.error().message().find(c.sentence), std::string::npos)
        << c.to << ": " << read.error().message();
  }
}

TEST(MetaImage, FlippedHeaderBytesNeverCrash) {
  ScratchFolder folder;
  std::mt19937 random(17);
  int refused = 0;
  for (int round = 0; round < 500; ++round) {
    auto bytes = with_voxels(header);
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      bytes[random() % header.size()] = static_cast<char>(random());
    put_bytes(folder / "a.mha", bytes);
    if (!read_volume(folder / "a.mha", as_hu)) ++refused;
  }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace borelli
