// Slices to volumes: copies, series and slice spacing. The tests write the series, so the right volume is
// known.
#include "segmentation/files/dicom_volumes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "segmentation/files/read.hpp"
#include "tests/segmentation/dicom_series.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli {
namespace dicom_volumes_test {
namespace {

using Eigen::Vector3d;

// Slice k of its series. All pixels are `value`, except the first: air.
TestSlice flat(int k, double z, int value, TestSlice slice = {}) {
  slice.columns = 3, slice.rows = 2;
  slice.position.z() = z;
  slice.instance = slice.series + "." + std::to_string(k + 1);
  slice.pixels.assign(6, static_cast<std::uint16_t>(value));
  slice.pixels[0] = 0;
  return slice;
}

// files whose names say nothing of their order
std::string name_of(int k) { return fmt::format("f{:04d}.dcm", k * 377 % 1009); }

bool says(const ScannedVolume& scan, const std::string& part) {
  return std::ranges::any_of(scan.warnings,
                             [&](const auto& note) { return note.find(part) != std::string::npos; });
}
std::string all_said(const ScannedVolume& scan) {
  std::string all;
  for (const auto& warning : scan.warnings) all += warning + "\n";
  return all;
}

// one CT number per slice
std::vector<std::int16_t> values(const ScannedVolume& scan) {
  std::vector<std::int16_t> along;
  for (std::int64_t k = 0; k < scan.volume.grid.size[2]; ++k) along.push_back(scan.volume.at(1, 1, k));
  return along;
}

TEST(DicomVolumes, KeepsSlicesWithOneInstanceUidAtDifferentPositions) {
  for (const int group : {2, 10, 61}) {
    const ScratchFolder folder;
    for (int k = 0; k < 61; ++k) {
      TestSlice slice = flat(k, 3 * k, 1000 + k);
      slice.instance = fmt::format("1.2.3.{}", 1 + k / group);
      write_slice(folder / name_of(k), slice);
    }
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->volume.grid.size[2], 61) << group;
    EXPECT_NEAR(read->volume.grid.spacing()[2], 3, 1e-9);
    for (int k = 0; k < 61; ++k) EXPECT_EQ(values(*read)[std::size_t(k)], k - 24);
    EXPECT_TRUE(read->warnings.empty()) << all_said(*read);
  }
}

TEST(DicomVolumes, RecognisesResentSlicesAsCopies) {
  const ScratchFolder folder;
  for (const int time : {0, 1})
    for (int k = 0; k < 9; ++k) {
      TestSlice slice = flat(k, 3 * k, 1000 + k);
      slice.instance += fmt::format(".{}", time + 7);
      write_slice(folder / fmt::format("{}{}", time, name_of(k)), slice);
    }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size[2], 9);
  EXPECT_TRUE(says(*read, "9 slices appear twice (same position, same pixels)")) << all_said(*read);
}

// The same pixels under another scaling are another picture.
TEST(DicomVolumes, CopiesNeedTheSameScaling) {
  const ScratchFolder folder;
  for (int k = 0; k < 4; ++k) write_slice(folder / name_of(k), flat(k, 3 * k, 1000 + k));
  TestSlice other = flat(2, 6, 1002);
  other.intercept = -1000;
  write_slice(folder / "other.dcm", other);
  const auto read = read_volume(folder.path());
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("two different slices at one position"), std::string::npos)
      << read.error().message();
}

TEST(DicomVolumes, JoinsSlicesWithOneSeriesEach) {
  for (const int times : {1, 2}) {
    const ScratchFolder folder;
    for (int time = 0; time < times; ++time)
      for (int k = 0; k < 12; ++k) {
        TestSlice slice = flat(k, 2 * k, 1000 + k);
        slice.series = fmt::format("1.2.3.{}.{}", time, k + 1);
        write_slice(folder / fmt::format("{}{}", time, name_of(k)), slice);
      }
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->volume.grid.size[2], 12);
    EXPECT_TRUE(says(*read, fmt::format("each of the {} slices has its own series UID", 12 * times)))
        << all_said(*read);
    EXPECT_FALSE(says(*read, "ignored")) << all_said(*read);
    EXPECT_EQ(says(*read, "12 slices appear twice"), times == 2);
  }
}

// Overwritten positions: the slice spacing is unknown.
TEST(DicomVolumes, RefusesSlicesOfOnePositionWithDifferentLocations) {
  const ScratchFolder folder;
  for (int k = 0; k < 4; ++k) {
    TestSlice slice = flat(k, 0, 1000 + k);
    slice.location = std::to_string(3 * k);
    write_slice(folder / name_of(k), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("though their SliceLocation is"), std::string::npos)
      << read.error().message();
}

// Two table positions: acquisition 1 from 0 to 30 mm, acquisition 2 from 24 to 57 mm. The second round shifts
// acquisition 2 by 1 mm, between the slices of the first.
TEST(DicomVolumes, JoinsAcquisitionsWithSmallOverlap) {
  for (const double shift : {0.0, 1.0}) {
    const ScratchFolder folder;
    for (int k = 0; k < 11; ++k) write_slice(folder / ("a" + name_of(k)), flat(k, 3 * k, 1000));
    for (int k = 0; k < 12; ++k) {
      TestSlice slice = flat(k + 20, 24 + shift + 3 * k, 1200);
      slice.acquisition = "2";
      write_slice(folder / ("b" + name_of(k)), slice);
    }
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    const Grid& grid = read->volume.grid;
    EXPECT_NEAR(grid.point(0, 0, 0).z(), 0, 1e-9);
    EXPECT_NEAR(grid.point(0, 0, grid.size[2] - 1).z(), 57 + shift, 1e-9);
    EXPECT_TRUE(says(*read, fmt::format("acquisition 1 overlaps acquisition 2 by {} mm", 6 - shift)))
        << all_said(*read);
    EXPECT_FALSE(says(*read, "ignored")) << all_said(*read);
    for (std::int64_t k = 0; k < grid.size[2]; ++k) {  // the larger one where both are
      const double z = grid.point(0, 0, k).z();
      if (z < 21) {
        EXPECT_EQ(read->volume.at(1, 1, k), -24) << z;
      } else if (z > 24 + shift) {
        EXPECT_EQ(read->volume.at(1, 1, k), 176) << z;
      }
    }
  }
}

// Acquisition 2 lies within acquisition 1: another picture, not another part of the body.
TEST(DicomVolumes, KeepsAcquisitionsOfOnePlaceApart) {
  const ScratchFolder folder;
  for (int k = 0; k < 11; ++k) write_slice(folder / ("a" + name_of(k)), flat(k, 3 * k, 1000));
  for (int k = 2; k < 9; ++k) {
    TestSlice slice = flat(k + 20, 3 * k, 1200);
    slice.acquisition = "2";
    write_slice(folder / ("b" + name_of(k)), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(values(*read), std::vector<std::int16_t>(11, -24));
  EXPECT_TRUE(says(*read,
                   "found 2 volumes of one series; read the largest CT, CT 'body', acquisition 1 (11 slices "
                   "of 3 x 2); ignored: CT 'body', acquisition 2 (7 slices"))
      << all_said(*read);
}

// 450 slices at 1.25 mm behind a gantry tilted by `tilt`, positions as `decimals` of a writer that rounds or
// cuts off.
void write_rounded(const ScratchFolder& folder, double tilt_deg, int decimals, bool cut, int but = -1) {
  const double tilt = tilt_deg * std::numbers::pi / 180;
  for (int k = 0; k < 450; ++k) {
    if (but > 0 && k % but == but - 1) continue;
    TestSlice slice = flat(k, (cut ? 100.3 : -100.3) + 1.25 * k, 1000 + k);
    slice.along_column = {0, std::cos(tilt), std::sin(tilt)};
    const auto text = [&](double value) {
      const double unit = std::pow(10, decimals);
      return fmt::format("{:.{}f}", cut ? std::trunc(value * unit + 1e-9) / unit : value, decimals);
    };
    slice.position_text = text(-10) + "\\" + text(-20) + "\\" + text(slice.position.z());
    write_slice(folder / name_of(k), slice);
  }
}

TEST(DicomVolumes, TreatsRoundedPositionsAsEven) {
  for (const auto& [tilt, decimals, cut] :
       {std::tuple(0.0, 1, false), {0.0, 1, true}, {15.0, 1, false}, {0.0, 2, false}}) {
    const ScratchFolder folder;
    write_rounded(folder, tilt, decimals, cut);
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->volume.grid.size[2], 450);
    // Errors of rounding need not be independent (halves are rounded away from zero on either side of it).
    // The worst for a least-squares slope are those of +a on one half of N places and -a on the other: 3 a /
    // N.
    const double half_unit = 0.5 * std::pow(10, -decimals);
    EXPECT_NEAR(read->volume.grid.axes(2, 2), 1.25, 3 * half_unit / 450);
    EXPECT_NEAR(read->volume.grid.origin.z(), cut ? 100.3 : -100.3, 0.06);
    EXPECT_FALSE(says(*read, "uneven") || says(*read, "missing")) << all_said(*read);
    for (int k = 0; k < 450; ++k) EXPECT_EQ(values(*read)[std::size_t(k)], k - 24);
  }
}

TEST(DicomVolumes, ReportsMissingSlicesBetweenRoundedPositions) {
  const ScratchFolder folder;
  write_rounded(folder, 0, 1, false, 20);  // each twentieth is not there: 22 of 450, none at the ends
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->volume.grid.size[2], 450);
  EXPECT_TRUE(says(*read, "22 slices are missing (the first behind slice 19)")) << all_said(*read);
  for (int k = 0; k < 450; ++k) EXPECT_EQ(values(*read)[std::size_t(k)], k - 24);
}

// Slice spacing of 3 mm, then 3.3 mm, with positions to 0.1 mm: too large a change for rounding.
TEST(DicomVolumes, RoundingHidesNoChangeOfSpacing) {
  const ScratchFolder folder;
  for (int k = 0; k < 60; ++k) {
    TestSlice slice = flat(k, 0, 1000 + k);
    slice.position_text = fmt::format("-10\\-20\\{:.1f}", k < 30 ? 3.0 * k : 90 + 3.3 * (k - 30));
    write_slice(folder / name_of(k), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(says(*read, "unevenly spaced, 3 mm to 3.3 mm apart")) << all_said(*read);
}

// The warnings about ten slices 2 mm apart with these header fields.
std::string said_of(const TestSlice& also, double slope_of_location = 0) {
  const ScratchFolder folder;
  for (int k = 0; k < 10; ++k) {
    TestSlice slice = flat(k, 2 * k, 1000 + k, also);
    if (slope_of_location != 0) slice.location = fmt::format("{:.2f}", 77 - slope_of_location * k);
    write_slice(folder / name_of(k), slice);
  }
  const auto read = read_volume(folder.path());
  if (!read) return read.error().message();
  EXPECT_NEAR(read->volume.grid.spacing()[2], 2, 1e-9);
  return all_said(*read);
}

TEST(DicomVolumes, ReportsFieldsThatContradictThePositions) {
  const auto with = [](std::string TestSlice::*field, const std::string& text) {
    TestSlice slice;
    slice.*field = text;
    return said_of(slice);
  };
  EXPECT_NE(with(&TestSlice::spacing_between, "4")
                .find("the slices' positions give a spacing of 2 mm, which was used, but SpacingBetweenSlices "
                      "gives 4 mm"),
            std::string::npos);
  EXPECT_NE(said_of({}, 5).find("SliceLocation gives 5 mm"), std::string::npos);
  EXPECT_NE(with(&TestSlice::thickness, "20").find("SliceThickness gives 20 mm"), std::string::npos);
  EXPECT_NE(with(&TestSlice::thickness, "0.1").find("SliceThickness gives 0.1 mm"), std::string::npos);
  // 3 columns at 0.75 mm
  EXPECT_NE(with(&TestSlice::diameter, "4.5").find("PixelSpacing gives a picture width of 2.25 mm"),
            std::string::npos);
}

TEST(DicomVolumes, IgnoresFieldsThatAgreeOrMeanSomethingElse) {
  const auto with = [](std::string TestSlice::*field, const std::string& text) {
    TestSlice slice;
    slice.*field = text;
    return said_of(slice);
  };
  EXPECT_EQ(with(&TestSlice::spacing_between, "2.0"), "");
  EXPECT_EQ(with(&TestSlice::thickness, "5"), "");    // overlap
  EXPECT_EQ(with(&TestSlice::thickness, "0.6"), "");  // gaps
  EXPECT_EQ(with(&TestSlice::diameter, "2.25"), "");
  EXPECT_EQ(said_of({}, 2), "");
  EXPECT_EQ(said_of({}, -2), "");
}

}  // namespace
}  // namespace dicom_volumes_test
}  // namespace borelli
