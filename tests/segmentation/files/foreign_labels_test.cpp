// Labels saved by other programs: as floating point, with a scale, along other axes.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "tests/segmentation/grids.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli::foreign_labels_test {
namespace {

template <class T>
void put_nrrd(const std::string& path, const std::string& type, const std::vector<T>& values) {
  const std::string header = "NRRD0004\ntype: " + type +
                             "\ndimension: 3\nspace: LPS\nsizes: " + std::to_string(values.size()) +
                             " 1 1\nspace directions: (2,0,0) (0,2,0) (0,0,3)\nendian: little\nencoding: "
                             "raw\n\n";
  std::vector<char> bytes(header.begin(), header.end());
  const auto* const first = reinterpret_cast<const char*>(values.data());
  bytes.insert(bytes.end(), first, first + sizeof(T) * values.size());
  put_bytes(path, bytes);
}

// a MetaImage whose values are slope * stored
template <class T>
void put_scaled(const std::string& path, const std::string& type, double slope,
                const std::vector<T>& values) {
  std::string header =
      "NDims = 3\nBinaryData = True\nElementByteOrderMSB = False\nOffset = 0 0 0\n"
      "ElementSpacing = 2 2 3\nElementToIntensityFunctionSlope = " +
      fmt::format("{}", slope) + "\nDimSize = " + std::to_string(values.size()) +
      " 1 1\nElementType = " + type + "\nElementDataFile = LOCAL\n";
  std::vector<char> bytes(header.begin(), header.end());
  const auto* const first = reinterpret_cast<const char*>(values.data());
  bytes.insert(bytes.end(), first, first + sizeof(T) * values.size());
  put_bytes(path, bytes);
}

TEST(ForeignLabels, RoundsNearlyWholeNumbersWithAWarning) {
  ScratchFolder folder;
  put_nrrd<float>(folder / "a.nrrd", "float", {0, 14.9999F, 15, 15.0001F, -0.0001F, 3});
  const auto read = read_labels(folder / "a.nrrd");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->voxels, (std::vector<std::uint8_t>{0, 15, 15, 15, 0, 3}));
  ASSERT_EQ(read->warnings.size(), 1U);
  EXPECT_NE(read->warnings[0].find("were rounded to whole numbers"), std::string::npos);
  put_nrrd<float>(folder / "b.nrrd", "float", {0, 15, 3});
  EXPECT_TRUE(read_labels(folder / "b.nrrd")->warnings.empty());
}

// Labels 0 to 117 scaled to the range of uint16: one step is 117 / 65535.
TEST(ForeignLabels, RoundsScaledIntegersWithinHalfAStep) {
  ScratchFolder folder;
  const double slope = 117. / 65535;
  std::vector<std::uint16_t> stored;
  std::vector<std::uint8_t> expected;
  for (int label = 0; label <= 117; ++label) {
    stored.push_back(static_cast<std::uint16_t>(std::lround(label / slope)));
    expected.push_back(static_cast<std::uint8_t>(label));
  }
  put_scaled(folder / "a.mha", "MET_USHORT", slope, stored);
  const auto read = read_labels(folder / "a.mha");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->voxels, expected);
  EXPECT_EQ(read->warnings.size(), 1U);
}

TEST(ForeignLabels, RefusesFractionsWithTheirDigits) {
  ScratchFolder folder;
  const auto refusal = [&](float value) {
    put_nrrd<float>(folder / "a.nrrd", "float", {0, 15, value});
    const auto read = read_labels(folder / "a.nrrd");
    return read ? "was read" : read.error().message();
  };
  EXPECT_NE(refusal(14.9375F).find("a voxel has the value 14.9375; labels are whole numbers"),
            std::string::npos)
      << refusal(14.9375F);
  EXPECT_NE(refusal(0.5F).find("the value 0.5"), std::string::npos);
  EXPECT_NE(refusal(-1).find("the value -1"), std::string::npos);
  EXPECT_NE(refusal(NAN).find("the value nan"), std::string::npos);
  EXPECT_NE(refusal(3e9F).find("the value 3e+09"), std::string::npos) << refusal(3e9F);
  put_scaled<std::uint8_t>(folder / "b.mha", "MET_UCHAR", 0.4, {0, 1, 2});
  EXPECT_FALSE(read_labels(folder / "b.mha")) << "0.4 is no label";
}

// The grid whose axis c runs along axis order[c] of `grid`, reversed if flip[c].
Grid turned(const Grid& grid, const std::array<int, 3>& order, const std::array<bool, 3>& flip) {
  Grid out = grid;
  for (int c = 0; c < 3; ++c) {
    const auto u = static_cast<std::size_t>(c);
    out.size[u] = grid.size[static_cast<std::size_t>(order[u])];
    out.axes.col(c) = grid.axes.col(order[u]);
    if (!flip[u]) continue;
    out.origin += static_cast<double>(out.size[u] - 1) * out.axes.col(c);
    out.axes.col(c) *= -1;
  }
  return out;
}

// All 48 orders and directions of the axes of a sheared oblique grid. A voxel's label depends on its position
// in the patient, not on the order of axes.
TEST(ForeignLabels, ReordersAxesToMatchTheScan) {
  ScratchFolder folder;
  const Grid scan = oblique_grid(false, 0.5);
  const auto label_at = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d index = scan.index(point).array().round();
    return static_cast<std::uint8_t>(1 + static_cast<int>(index[0] + 7 * index[1] + 49 * index[2]) % 250);
  };
  std::vector<std::uint8_t> expected;
  for (std::int64_t k = 0; k < scan.size[2]; ++k)
    for (std::int64_t j = 0; j < scan.size[1]; ++j)
      for (std::int64_t i = 0; i < scan.size[0]; ++i) expected.push_back(label_at(scan.point(i, j, k)));
  std::array<int, 3> order{0, 1, 2};
  int turns = 0;
  do {
    for (int flips = 0; flips < 8; ++flips) {
      LabelMap map;
      map.grid = turned(scan, order, {(flips & 1) != 0, (flips & 2) != 0, (flips & 4) != 0});
      for (std::int64_t k = 0; k < map.grid.size[2]; ++k)
        for (std::int64_t j = 0; j < map.grid.size[1]; ++j)
          for (std::int64_t i = 0; i < map.grid.size[0]; ++i)
            map.voxels.push_back(label_at(map.grid.point(i, j, k)));
      map.names = {"outside"};
      ASSERT_TRUE(write_labels(folder / "a.nrrd", map));
      std::filesystem::remove(folder / "a.tsv");
      const auto read = read_labels(folder / "a.nrrd", "", {}, &scan);
      ASSERT_TRUE(read) << read.error().message();
      EXPECT_TRUE(same_grid(read->grid, scan));
      EXPECT_EQ(read->voxels, expected);
      const bool as_the_scan = flips == 0 && order == std::array<int, 3>{0, 1, 2};
      EXPECT_EQ(read->warnings.size(), as_the_scan ? 0U : 1U);
      ++turns;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(turns, 48);
}

// 4 x 1 x 1 voxels of a label along a scan of 6, shifted by -1 and 3, and cropped to their labels.
TEST(ForeignLabels, KnowsWhatLiesBeyondTheScanAndWhatTheMapDoesNotCover) {
  ScratchFolder folder;
  Grid scan;
  scan.size = {6, 3, 3};
  const auto placed = [&](std::int64_t shift, std::vector<std::uint8_t> row) {
    LabelMap map;
    map.grid.size = {4, 1, 1};
    map.grid.origin = scan.point(shift, 1, 1);
    map.voxels = std::move(row), map.names = {"outside", "one", "two"};
    EXPECT_TRUE(write_labels(folder / "a.nrrd", map));
    auto read = read_labels(folder / "a.nrrd", "", {}, &scan);
    EXPECT_TRUE(read);
    return *read;
  };
  const LabelMap low = placed(-1, {1, 1, 2, 0});
  EXPECT_EQ(low.beyond, std::set<std::uint8_t>{1});
  ASSERT_TRUE(low.labelled);
  EXPECT_EQ(low.labelled->first, (std::array<std::int64_t, 3>{0, 1, 1}));
  EXPECT_EQ(low.labelled->last, (std::array<std::int64_t, 3>{2, 1, 1}));
  ASSERT_EQ(low.warnings.size(), 1U);
  EXPECT_EQ(low.warnings[0], "voxels outside the scan were left out: one 50 %");
  const LabelMap high = placed(3, {0, 1, 1, 2});
  EXPECT_EQ(high.beyond, std::set<std::uint8_t>{2});
  EXPECT_EQ(high.warnings[0], "voxels outside the scan were left out: two 100 %");
  const LabelMap cropped = placed(1, {1, 1, 2, 2});
  EXPECT_TRUE(cropped.beyond.empty());
  EXPECT_FALSE(cropped.labelled);
  EXPECT_TRUE(cropped.warnings.empty());
}

TEST(ForeignLabels, RefusesAnotherGridBeforeReadingVoxels) {
  ScratchFolder folder;
  LabelMap map;
  map.grid = oblique_grid(false, 0);
  map.voxels.assign(map.grid.count(), 1);
  map.names = {"outside", "one"};
  ASSERT_TRUE(write_labels(folder / "a.nrrd", map));
  // cut off the voxels
  auto bytes = file_bytes(folder / "a.nrrd");
  bytes.resize(bytes.size() - 40);
  put_bytes(folder / "a.nrrd", bytes);
  Grid shifted = map.grid, coarser = map.grid, turned_a_little = map.grid;
  shifted.origin += 0.3 * shifted.axes.col(0);
  coarser.axes.col(2) *= 2;
  turned_a_little.axes = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()) * turned_a_little.axes;
  for (const Grid& scan : {shifted, coarser, turned_a_little}) {
    const auto read = read_labels(folder / "a.nrrd", "", {}, &scan);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, Error::Kind::use);
    EXPECT_NE(read.error().message().find("lies on another grid (5 x 7 x 4 voxels of 0.7 x 1.3 x 5 mm)"),
              std::string::npos)
        << read.error().message();
  }
}

}  // namespace
}  // namespace borelli::foreign_labels_test
