// Headers that give the voxel size more than once. The files are written by hand, so the right size is known.
#include "segmentation/files/voxel_size.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

#include "segmentation/files/read.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli::voxel_size_test {
namespace {

using Eigen::Vector3d;

const std::vector<std::int16_t> four{-1000, 0, 40, 3000};

bool tells(const std::vector<std::string>& warnings, const std::string& part) {
  return std::ranges::any_of(warnings, [&](const auto& w) { return w.find(part) != std::string::npos; });
}

std::vector<char> with_voxels(std::vector<char> bytes) {
  const auto* first = reinterpret_cast<const char*>(four.data());
  bytes.insert(bytes.end(), first, first + 2 * four.size());
  return bytes;
}

Result<ScannedVolume> read(const std::string& name, const std::vector<char>& bytes) {
  ScratchFolder folder;
  put_bytes(folder / name, with_voxels(bytes));
  return read_volume(folder / name, {FileQuantity::hu, {}});
}

// A NIfTI-1 header (nifti1.h) of 2 x 2 x 1 voxels: sform's columns along the axes with these lengths, pixdim,
// and, if requested, a qform without rotation.
Result<ScannedVolume> nifti(const Vector3d& sform, const Vector3d& pixdim, bool qform, float slope = 1) {
  std::vector<char> bytes(352, 0);
  const auto set = [&](std::size_t offset, auto value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
  };
  set(0, std::int32_t{348}), set(70, std::int16_t{4}), set(72, std::int16_t{16});
  const std::array<std::int16_t, 4> dim{3, 2, 2, 1};
  for (std::size_t i = 0; i < 4; ++i) set(40 + 2 * i, dim[i]);
  set(76, 1.F), set(108, 352.F), set(112, slope), set(116, 0.F);
  for (std::size_t i = 0; i < 3; ++i) {
    set(80 + 4 * i, static_cast<float>(pixdim[static_cast<int>(i)]));
    set(280 + 20 * i, static_cast<float>(sform[static_cast<int>(i)]));
  }
  bytes[123] = 2;
  set(252, static_cast<std::int16_t>(qform)), set(254, std::int16_t{1});
  std::memcpy(bytes.data() + 344, "n+1", 4);
  return read("a.nii", bytes);
}

TEST(VoxelSize, NiftiUsesTheMajorityWithAWarning) {
  const Vector3d right(0.75, 0.75, 3), thick(0.75, 0.75, 4), ones(1, 1, 1);
  const auto agreed = nifti(right, right, true);
  ASSERT_TRUE(agreed) << agreed.error().message();
  EXPECT_TRUE(agreed->warnings.empty()) << agreed->warnings[0];
  struct Case {
    Vector3d sform, pixdim;
    bool qform;
  };
  // a slice thickness; directions alone, with and without a qform; an unset pixdim, which a qform repeats
  for (const Case& c : {Case{thick, right, true},
                        {ones, right, true},
                        {ones, right, false},
                        {right, ones, false},
                        {right, ones, true}}) {
    const auto scan = nifti(c.sform, c.pixdim, c.qform);
    ASSERT_TRUE(scan) << scan.error().message();
    EXPECT_LT((scan->volume.grid.spacing() - right).norm(), 1e-6) << c.sform.transpose();
    EXPECT_TRUE(tells(scan->warnings, "different voxel sizes (sform"));
    EXPECT_TRUE(tells(scan->warnings, "0.75 x 0.75 x 3 was used"));
  }
  const auto tie = nifti(thick, right, false);
  ASSERT_FALSE(tie);
  EXPECT_NE(
      tie.error().message().find("contradictory voxel sizes (sform 0.75 x 0.75 x 4, pixdim 0.75 x 0.75 x 3)"),
      std::string::npos)
      << tie.error().message();
}

// A thickness alone is not trusted against lengths of 1, which may be right.
TEST(VoxelSize, FieldsThatMayDifferDoNotOverruleOnes) {
  std::vector<std::string> warnings;
  const SizeField ones{"directions", Vector3d::Ones()}, thick{"thicknesses", {2, 2, 5}, true},
      along_one_axis{"thicknesses", {NAN, NAN, 5}, true};
  EXPECT_FALSE(voxel_size("a.nrrd", {ones, thick}, warnings));
  const auto kept = voxel_size("a.nrrd", {ones, along_one_axis}, warnings);
  ASSERT_TRUE(kept) << kept.error().message();
  EXPECT_EQ(*kept, Vector3d::Ones());
}

TEST(VoxelSize, NiftiIgnoresASlopeThatIsNotANumber) {
  const Vector3d size(2, 2, 3);
  const auto scan = nifti(size, size, true, NAN);
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->volume.voxels, four);
  EXPECT_FALSE(nifti(size, size, true, INFINITY));
}

Result<ScannedVolume> nrrd(const std::string& sizes) {
  const std::string text =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 1\nencoding: raw\nendian: little\n"
      "space: left-posterior-superior\n" +
      sizes + "\n";
  return read("a.nrrd", {text.begin(), text.end()});
}

TEST(VoxelSize, NrrdComparesDirectionsSpacingsAndThicknesses) {
  const auto directions = [](const std::string& k) {
    return "space directions: (2,0,0) (0,2,0) (0,0," + k + ")\n";
  };
  const auto agreed = nrrd(directions("3") + "spacings: 2 2 3\nthicknesses: nan nan 3\n");
  ASSERT_TRUE(agreed) << agreed.error().message();
  EXPECT_TRUE(agreed->warnings.empty()) << agreed->warnings[0];
  // two of three; a thickness alone, which may differ where slices overlap; directions without lengths
  for (const std::string& sizes :
       {directions("4") + "spacings: 2 2 3\nthicknesses: nan nan 3\n",
        directions("3") + "spacings: 2 2 4\nthicknesses: nan nan 3\n",
        directions("3") + "thicknesses: nan nan 4\n",
        std::string("space directions: (1,0,0) (0,1,0) (0,0,1)\nspacings: 2 2 3\n")}) {
    const auto scan = nrrd(sizes);
    ASSERT_TRUE(scan) << scan.error().message();
    EXPECT_EQ(scan->volume.grid.spacing(), Vector3d(2, 2, 3)) << sizes;
    EXPECT_TRUE(tells(scan->warnings, "2 x 2 x 3 was used")) << sizes;
  }
  const auto tie = nrrd(directions("4") + "spacings: 2 2 3\n");
  ASSERT_FALSE(tie);
  EXPECT_NE(tie.error().message().find("contradictory voxel sizes"), std::string::npos);
}

Result<ScannedVolume> metaimage(const std::string& sizes) {
  const std::string text =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" + sizes +
      "DimSize = 2 2 1\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  return read("a.mha", {text.begin(), text.end()});
}

TEST(VoxelSize, MetaImageComparesSpacingSizeAndMatrix) {
  const std::string spacing = "ElementSpacing = 2 2 3\n", unit = "TransformMatrix = 0 1 0 1 0 0 0 0 1\n",
                    scaled = "TransformMatrix = 0 2 0 2 0 0 0 0 3\n";
  const auto agreed = metaimage(spacing + "ElementSize = 2 2 3\n" + unit);
  ASSERT_TRUE(agreed) << agreed.error().message();
  EXPECT_TRUE(agreed->warnings.empty()) << agreed->warnings[0];
  struct Case {
    std::string sizes;
    bool told;
  };
  // a size alone, as for slices with gaps; sizes in the matrix too, or only there; both against a spacing
  for (const Case& c : {Case{spacing + "ElementSize = 2 2 4\n" + unit, true},
                        {spacing + scaled, false},
                        {"ElementSpacing = 1 1 1\n" + scaled, true},
                        {"ElementSpacing = 2 2 4\nElementSize = 2 2 3\n" + scaled, true}}) {
    const auto scan = metaimage(c.sizes);
    ASSERT_TRUE(scan) << scan.error().message();
    EXPECT_LT((scan->volume.grid.spacing() - Vector3d(2, 2, 3)).norm(), 1e-12) << c.sizes;
    EXPECT_EQ(scan->volume.grid.point({1, 0, 0}), Vector3d(0, 2, 0));
    EXPECT_EQ(tells(scan->warnings, "2 x 2 x 3 was used"), c.told) << c.sizes;
  }
  EXPECT_FALSE(metaimage("ElementSpacing = 1 1 1\nElementSize = 6 6 6\n" + unit));
  const auto tie = metaimage("ElementSpacing = 2 2 4\n" + scaled);
  ASSERT_FALSE(tie);
  EXPECT_NE(tie.error().message().find("contradictory voxel sizes"), std::string::npos);
}

// Numbers with decimal commas, and too many or too few numbers, in every field of both formats.
TEST(VoxelSize, RefusesHeadersWithOtherNumbersThanExpected) {
  const std::string directions = "space directions: (2,0,0) (0,2,0) (0,0,3)\n",
                    spacing = "ElementSpacing = 2 2 3\n";
  ASSERT_TRUE(nrrd("spacings: 2 2 3\n"));
  ASSERT_TRUE(nrrd("spacings: 2, 2, 3\n"));
  for (const std::string& sizes : {std::string("spacings: 2,5 2,5 5,0\n"), std::string("spacings: 2 2 5 7\n"),
                                   std::string("spacings: 2 2\n"), directions + "thicknesses: 2,5 2,5 3,0\n",
                                   directions + "space origin: (1,5,2,5,3,0)\n",
                                   std::string("space directions: (2,5,0,0) (0,2,0) (0,0,3)\n")})
    EXPECT_FALSE(nrrd(sizes)) << sizes;
  const auto told = nrrd("spacings: 2,5 2,5 5,0\n");
  EXPECT_NE(
      told.error().message().find("'spacings' is '2,5 2,5 5,0'; expected 3 numbers separated by blanks, with "
                                  "decimal points instead of commas"),
      std::string::npos)
      << told.error().message();
  for (const std::string& sizes :
       {std::string("ElementSpacing = 2,5 2,5 3,0\n"), std::string("ElementSpacing = 2 2 3 4\n"),
        spacing + "Offset = 1,5 2,5 3,5\n", spacing + "ElementSize = 2 2\n",
        spacing + "TransformMatrix = 1 0 0 0 1 0 0 0\n"})
    EXPECT_FALSE(metaimage(sizes)) << sizes;
}

}  // namespace
}  // namespace borelli::voxel_size_test
