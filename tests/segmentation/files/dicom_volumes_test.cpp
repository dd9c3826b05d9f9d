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

// file names unrelated to the order
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
  EXPECT_TRUE(says(*read, "9 slices appear twice (same position, same values)")) << all_said(*read);
}

// The same values with more bits and another intercept: all stored numbers differ.
TEST(DicomVolumes, RecognisesCopiesThatAreStoredInAnotherWay) {
  const ScratchFolder folder;
  for (int k = 0; k < 9; ++k) {
    TestSlice slice = flat(k, 3 * k, 1000 + k);
    write_slice(folder / name_of(k), slice);
    slice.intercept -= 24, slice.bits_stored = 16;
    for (auto& pixel : slice.pixels) pixel = static_cast<std::uint16_t>(pixel + 24);
    write_slice(folder / ("again" + name_of(k)), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->volume.grid.size[2], 9);
  EXPECT_TRUE(says(*read, "9 slices appear twice")) << all_said(*read);
  for (int k = 0; k < 9; ++k) EXPECT_EQ(values(*read)[std::size_t(k)], k - 24);
}

// The same pixels with another scaling are another image.
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

// Series and descriptions of one, two and five slices each; of one, also with uneven places.
TEST(DicomVolumes, JoinsSeriesOfFewSlices) {
  for (const auto& [together, uneven] : {std::pair(1, false), {1, true}, {2, false}, {5, false}}) {
    const ScratchFolder folder;
    for (int k = 0; k < 31; ++k) {
      TestSlice slice = flat(k, 2 * k + (uneven && k > 10), 1000 + k);
      slice.series = fmt::format("1.2.3.4.{}", k / together);
      slice.description = fmt::format("part {}", k / together);
      write_slice(folder / name_of(k), slice);
    }
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->volume.grid.size[2], uneven ? 32 : 31) << together;  // 61 mm; the usual step is 2 mm
    EXPECT_TRUE(says(*read, fmt::format("its slices have {} different series", (30 + together) / together)))
        << all_said(*read);
    EXPECT_EQ(says(*read, "unevenly spaced"), uneven);
    if (uneven) continue;
    for (int k = 0; k < 31; ++k) EXPECT_EQ(values(*read)[std::size_t(k)], k - 24);
  }
}

// Two scans of 5 slices at the same places, and a scout of 3: no series is joined with another.
TEST(DicomVolumes, KeepsSmallSeriesOfTheSamePlacesApart) {
  const ScratchFolder folder;
  for (int series = 0; series < 3; ++series)
    for (int k = 0; k < 5 - series; ++k) {
      TestSlice slice = flat(k, 3 * k, 1000 + 100 * series + k);
      slice.series = fmt::format("1.2.3.4.{}", series);
      write_slice(folder / fmt::format("{}{}", series, name_of(k)), slice);
    }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size[2], 5);
  EXPECT_TRUE(says(*read, "found 3 series; read the largest CT")) << all_said(*read);
}

TEST(DicomVolumes, ReportsImagesThatWereLeftOut) {
  const ScratchFolder folder;
  for (int k = 0; k < 20; ++k) {
    TestSlice slice = flat(k, 3 * k, 1000 + k);
    if (k >= 15) slice.position_text = "1\\2";
    write_slice(folder / fmt::format("f{:02}.dcm", k), slice);
  }
  put_bytes(folder / "f30.dcm", std::vector<char>(5000, 'x'));
  put_bytes(folder / "f31.dcm.gz", std::vector<char>(5000, 'x'));
  put_bytes(folder / "notes.txt", std::vector<char>(5000, 'x'));
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size[2], 15);
  EXPECT_TRUE(says(*read, "5 files (the first is f15.dcm) do not state their position")) << all_said(*read);
  EXPECT_TRUE(says(*read, "2 files (the first is f30.dcm) hold no DICOM image; ignored")) << all_said(*read);
}

TEST(DicomVolumes, RefusesSlicesWithoutTheScalingOfTheOthers) {
  for (const int every : {2, 10}) {
    const ScratchFolder folder;
    for (int k = 0; k < 20; ++k) {
      TestSlice slice = flat(k, 3 * k, 1000 + k);
      slice.scaled = k % every != 0;
      write_slice(folder / name_of(k), slice);
    }
    const auto read = read_volume(folder.path());
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message().find(
                  fmt::format("lacks RescaleSlope and RescaleIntercept in {} of its 20 slices", 20 / every)),
              std::string::npos)
        << read.error().message();
  }
}

// Every tenth slice holds signed numbers and says that they are unsigned.
TEST(DicomVolumes, RefusesSomeSignedSlicesDeclaredUnsigned) {
  const ScratchFolder folder;
  for (int k = 0; k < 20; ++k) {
    TestSlice slice = flat(k, 3 * k, k);
    slice.pixels[0] = static_cast<std::uint16_t>(-1000);
    slice.intercept = 0, slice.bits_stored = 16;
    slice.is_signed = k % 10 != 0;
    write_slice(folder / name_of(k), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("declares 18 of its 20 slices as signed"), std::string::npos)
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
    EXPECT_TRUE(says(*read, fmt::format("its slices have {} different series UIDs", 12 * times)))
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
    for (std::int64_t k = 0; k < grid.size[2]; ++k) {  // the larger value where both overlap
      const double z = grid.point(0, 0, k).z();
      if (z < 21) {
        EXPECT_EQ(read->volume.at(1, 1, k), -24) << z;
      } else if (z > 24 + shift) {
        EXPECT_EQ(read->volume.at(1, 1, k), 176) << z;
      }
    }
  }
}

// Acquisition 2 lies within acquisition 1: another image, not another part of the body.
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

// 450 slices at 1.25 mm behind a gantry tilted by `tilt`, positions with `decimals`, rounded or (`cut`)
// truncated.
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
    // Rounding errors need not be independent (halves are rounded away from zero on both sides). The worst
    // case for a least-squares slope is +a on one half of N positions and -a on the other: 3 a / N.
    const double half_unit = 0.5 * std::pow(10, -decimals);
    EXPECT_NEAR(read->volume.grid.axes(2, 2), 1.25, 3 * half_unit / 450);
    EXPECT_NEAR(read->volume.grid.origin.z(), cut ? 100.3 : -100.3, 0.06);
    EXPECT_FALSE(says(*read, "uneven") || says(*read, "missing")) << all_said(*read);
    for (int k = 0; k < 450; ++k) EXPECT_EQ(values(*read)[std::size_t(k)], k - 24);
  }
}

TEST(DicomVolumes, ReportsMissingSlicesBetweenRoundedPositions) {
  const ScratchFolder folder;
  write_rounded(folder, 0, 1, false, 20);  // every twentieth is missing: 22 of 450, none at the ends
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->volume.grid.size[2], 450);
  EXPECT_TRUE(says(*read, "22 slices are missing (the first behind slice 19)")) << all_said(*read);
  for (int k = 0; k < 450; ++k) EXPECT_EQ(values(*read)[std::size_t(k)], k - 24);
}

// Half of the unit is a fifth of the step: 2.5 mm to 1 mm gives steps of 2 and 3 mm, to which 1.67 mm with
// missing slices would fit as well.
TEST(DicomVolumes, PrefersNoMissingSlicesToCoarsePositions) {
  for (const auto& [step, decimals] : {std::pair(2.5, 0), {0.25, 1}}) {
    const ScratchFolder folder;
    for (int k = 0; k < 90; ++k) {
      TestSlice slice = flat(k, 0, 1000 + k);
      slice.position_text = fmt::format("-10\\-20\\{:.{}f}", step * k, decimals);
      write_slice(folder / name_of(k), slice);
    }
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->volume.grid.size[2], 90) << step;
    EXPECT_NEAR(read->volume.grid.spacing()[2], step, 0.01 * step);
    EXPECT_FALSE(says(*read, "uneven") || says(*read, "missing")) << all_said(*read);
  }
}

// Slice spacing of 3 mm, then 3.3 mm, with positions to 0.1 mm: more than rounding explains.
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
  EXPECT_NE(
      with(&TestSlice::spacing_between, "4")
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

TEST(DicomVolumes, RefusesPositionsThatTwoFieldsContradict) {
  TestSlice slice;
  slice.spacing_between = "6", slice.thickness = "6";
  const std::string told = said_of(slice, 6);
  EXPECT_NE(
      told.find("gives contradictory slice spacings, and masses depend on them: its positions give 2 mm, but "
                "SpacingBetweenSlices gives 6 mm, SliceLocation gives 6 mm"),
      std::string::npos)
      << told;
  // two fields that also contradict each other leave the positions
  EXPECT_NE(said_of(slice, 4).find("the slices' positions give a spacing of 2 mm, which was used"),
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
