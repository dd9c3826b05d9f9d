// DICOM folders: series written here slice by slice, so the right volume is known, and real ones.
#include "segmentation/files/dicom.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <tuple>

#include "dicom_series.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/dicom_slice.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// a value unique for slice, row and column
std::uint16_t stored(int k, int row, int column) {
  return static_cast<std::uint16_t>(1000 + 100 * k + 10 * row + column);
}

// slice k of n: `slice` at its position with the pixels above
TestSlice numbered(TestSlice slice, int k, const Vector3d& step) {
  slice.position += k * step;
  slice.instance = slice.series + "." + std::to_string(k + 1);
  slice.pixels.clear();
  for (int row = 0; row < slice.rows; ++row)
    for (int column = 0; column < slice.columns; ++column) slice.pixels.push_back(stored(k, row, column));
  return slice;
}

// file names unrelated to the order
std::string shuffled_name(int k) { return fmt::format("f{:03d}.dcm", k * 37 % 101); }

void write_series(const ScratchFolder& folder, const TestSlice& slice, int count, const Vector3d& step,
                  const std::string& prefix = "") {
  for (int k = 0; k < count; ++k) write_slice(folder / (prefix + shuffled_name(k)), numbered(slice, k, step));
}

bool says(const std::vector<std::string>& notes, const std::string& part) {
  return std::ranges::any_of(notes, [&](const auto& note) { return note.find(part) != std::string::npos; });
}

// decimals of the test's headers end at 1e-6 mm
constexpr double decimals = 2e-6;

TEST(Dicom, SortsByPositionAndRescales) {
  ScratchFolder folder;
  TestSlice slice;
  slice.slope = 0.5, slice.intercept = -1000;
  write_series(folder, slice, 7, {0, 0, 2.5});
  std::vector<double> progress;
  const auto read = read_volume(folder.path(), {{}, [&](double share) { progress.push_back(share); }});
  ASSERT_TRUE(read) << read.error().message();
  const Grid& grid = read->volume.grid;
  EXPECT_EQ(grid.size, (std::array<std::int64_t, 3>{6, 5, 7}));
  EXPECT_LT((grid.axes - Eigen::Matrix3d(Vector3d(0.75, 0.5, 2.5).asDiagonal())).norm(), decimals);
  EXPECT_LT((grid.origin - Vector3d(-10, -20, 30)).norm(), decimals);
  for (int k = 0; k < 7; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 6; ++i) {
        const double exact = 0.5 * stored(k, j, i) - 1000;
        EXPECT_LE(std::abs(read->volume.at(i, j, k) - exact), 0.5);  // whole numbers
      }
  EXPECT_EQ(read->volume.quantity, Quantity::hu);
  EXPECT_EQ(read->modality, "CT");
  EXPECT_EQ(read->series_description, "body");
  EXPECT_EQ(read->reading, "CT numbers (hu): the series is DICOM CT");
  for (const std::string& warning : read->warnings)  // the pixels show neither air nor lungs
    EXPECT_NE(warning.find("near -1000, where air lies"), std::string::npos) << warning;
  EXPECT_TRUE(std::ranges::is_sorted(progress));
  EXPECT_EQ(progress.back(), 1);
}

// Pixels after PS3.5, 8.1.1: the value is in a word's bits from HighBit down.
template <class T>
void expect_decoded(int allocated, int stored_bits, int high_bit, bool is_signed, bool big_endian) {
  SCOPED_TRACE(fmt::format("{} bits, {} stored up to {}, {}, {}, into {} bytes", allocated, stored_bits,
                           high_bit, is_signed, big_endian, sizeof(T)));
  constexpr int columns = 13, rows = 7;
  std::mt19937 random(4);
  std::vector<char> bytes(5, 'x');  // before the pixels
  std::vector<T> expected;
  for (int n = 0; n < columns * rows; ++n) {
    const std::uint64_t word = random() % (std::uint64_t{1} << allocated);
    for (int b = 0; b < allocated / 8; ++b)
      bytes.push_back(static_cast<char>(word >> 8 * (big_endian ? allocated / 8 - 1 - b : b)));
    const std::int64_t range = std::int64_t{1} << stored_bits;
    std::int64_t value = static_cast<std::int64_t>(word >> (high_bit + 1 - stored_bits)) % range;
    if (is_signed && value >= range / 2) value -= range;
    expected.push_back(static_cast<T>(value));
  }
  ScratchFolder folder;
  put_bytes(folder / "pixels", bytes);
  DicomSlice slice;
  slice.path = folder / "pixels";
  slice.columns = columns, slice.rows = rows;
  slice.pixels.bits_allocated = allocated, slice.pixels.bits_stored = stored_bits;
  slice.pixels.high_bit = high_bit;
  slice.pixels.is_signed = is_signed, slice.pixels.big_endian = big_endian;
  slice.pixels.offset = 5, slice.pixels.bytes = bytes.size() - 5;
  std::vector<T> pixels(columns * rows);
  const auto read = read_dicom_pixels(slice, std::span(pixels));
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(pixels, expected);
}

TEST(Dicom, ReadsThePixelBitsThatTheHeaderNames) {
  for (const bool is_signed : {false, true})
    for (const bool big_endian : {false, true})
      for (const auto& [allocated, stored_bits, high_bit] : {std::tuple(8, 8, 7),
                                                             {8, 5, 6},
                                                             {16, 16, 15},
                                                             {16, 12, 11},
                                                             {16, 12, 15},
                                                             {16, 10, 12},
                                                             {32, 32, 31},
                                                             {32, 20, 27},
                                                             {32, 1, 0}}) {
        expect_decoded<std::int32_t>(allocated, stored_bits, high_bit, is_signed, big_endian);
        if (allocated <= 16)
          expect_decoded<std::int16_t>(allocated, stored_bits, high_bit, is_signed, big_endian);
      }
}

// With a gantry tilted by 20 degrees the slices are tilted while the table moves along z, so the grid is
// sheared. A voxel lies where its slice's header puts it.
TEST(Dicom, GantryTiltShearsTheGrid) {
  ScratchFolder folder;
  const double tilt = 20 * std::numbers::pi / 180;
  TestSlice slice;
  slice.along_column = {0, std::cos(tilt), std::sin(tilt)};
  write_series(folder, slice, 9, {0, 0, 3});
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  for (const int k : {0, 4, 8}) {
    const TestSlice own = numbered(slice, k, {0, 0, 3});
    const Vector3d expected = own.position + 2 * 0.75 * own.along_row + 3 * 0.5 * own.along_column;
    EXPECT_LT((read->volume.grid.point({2, 3, static_cast<double>(k)}) - expected).norm(), 1e-5);
    EXPECT_EQ(read->volume.at(2, 3, k), stored(k, 3, 2) - 1024);
  }
  EXPECT_TRUE(says(read->warnings, "tilted by 20 degrees"));
}

// rows to the front, columns down, slices to the left: the third axis follows the slices in any direction
TEST(Dicom, ReadsSagittalSlices) {
  ScratchFolder folder;
  TestSlice slice;
  slice.modality = "MR", slice.intercept = 0;
  slice.along_row = {0, 1, 0}, slice.along_column = {0, 0, -1};
  write_series(folder, slice, 4, {4, 0, 0});
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.quantity, Quantity::mr);
  EXPECT_GT(read->volume.grid.axes.determinant(), 0) << "slices are ordered along row x column";
  for (int k = 0; k < 4; ++k) {
    const Vector3d index = read->volume.grid.index(slice.position + k * Vector3d(4, 0, 0));
    EXPECT_LT((index - Vector3d(0, 0, std::round(index.z()))).norm(), 1e-5);
    EXPECT_EQ(read->volume.at(5, 1, std::lround(index.z())), stored(k, 1, 5));
  }
}

TEST(Dicom, ReadsTheLargestCtSeriesAndSaysSo) {
  ScratchFolder folder;
  TestSlice small, large, mr;
  small.description = "scout";
  large.series = "1.2.3.2", large.description = "thorax";
  mr.series = "1.2.3.3", mr.modality = "MR", mr.columns = 12;
  write_series(folder, small, 2, {0, 0, 5}, "a");
  write_series(folder, large, 5, {0, 0, 5}, "b");
  write_series(folder, mr, 9, {0, 0, 5}, "c");
  put_bytes(folder / "notes.txt", std::vector<char>(500, 'x'));
  put_bytes(folder / "empty", {});
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->series_description, "thorax");
  EXPECT_EQ(read->volume.grid.size[2], 5);
  EXPECT_TRUE(says(read->warnings, "found 3 series; read the largest CT, CT 'thorax' (5 slices of 6 x 5)"));
  EXPECT_TRUE(says(read->warnings, "CT 'scout' (2 slices"));
}

// a localizer of another orientation in the same series does not belong to the volume
TEST(Dicom, SplitsASeriesByOrientation) {
  ScratchFolder folder;
  TestSlice axial, scout;
  scout.along_column = {0, 0, -1};
  write_series(folder, axial, 6, {0, 0, 5}, "a");
  TestSlice one = numbered(scout, 0, {0, 0, 0});
  one.instance = "1.2.3.9";
  write_slice(folder / "scout.dcm", one);
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size[2], 6);
}

TEST(Dicom, ScalingMayDifferFromSliceToSlice) {
  ScratchFolder folder;
  for (int k = 0; k < 4; ++k) {
    TestSlice slice = numbered({}, k, {0, 0, 2});
    slice.slope = 1 + 0.25 * k, slice.intercept = -1000 + 10 * k;
    write_slice(folder / shuffled_name(k), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  for (int k = 0; k < 4; ++k)
    EXPECT_LE(std::abs(read->volume.at(1, 2, k) - ((1 + 0.25 * k) * stored(k, 2, 1) - 1000 + 10 * k)), 0.5);
}

// 12 bits with sign: bits above the stored ones are ignored
TEST(Dicom, ReadsSignedPixelsOfTwelveBits) {
  ScratchFolder folder;
  for (int k = 0; k < 3; ++k) {
    TestSlice slice = numbered({}, k, {0, 0, 2});
    slice.is_signed = true, slice.intercept = 0;
    for (auto& p : slice.pixels) p = static_cast<std::uint16_t>((p - 1100) & 0x0fff);
    write_slice(folder / shuffled_name(k), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.at(3, 2, 0), stored(0, 2, 3) - 1100);  // negative
  EXPECT_EQ(read->volume.at(3, 2, 2), stored(2, 2, 3) - 1100);
}

TEST(Dicom, ReportsPaddingOfAnyValue) {
  for (const int padding :
       {-2000, 0}) {  // 0 with intercept 0 is water; it is padding only outside the image circle
    ScratchFolder folder;
    for (int k = 0; k < 3; ++k) {
      TestSlice slice = numbered({}, k, {0, 0, 2});
      slice.is_signed = true, slice.bits_stored = 16, slice.intercept = 0,
      slice.padding = static_cast<std::uint16_t>(padding);
      for (auto& p : slice.pixels) p = static_cast<std::uint16_t>(p - 900);
      slice.pixels[0] = slice.pixels[1] = slice.pixels[5] = static_cast<std::uint16_t>(padding);
      slice.pixels[3] = 0;
      write_slice(folder / shuffled_name(k), slice);
    }
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->volume.at(0, 0, 1), padding_hu) << padding;
    EXPECT_EQ(read->volume.at(1, 0, 1), padding_hu) << padding;
    EXPECT_EQ(read->volume.at(5, 0, 1), padding_hu) << padding;
    EXPECT_EQ(read->volume.at(2, 0, 1), stored(1, 0, 2) - 900) << padding;
    EXPECT_EQ(read->volume.at(3, 0, 1), 0) << padding;  // inside
  }
}

TEST(Dicom, InterpolatesMissingSlicesWithANote) {
  ScratchFolder folder;
  const Vector3d step(0, 0.4, 3);  // tilted too
  for (const int k : {0, 1, 2, 5, 6, 7}) write_slice(folder / shuffled_name(k), numbered({}, k, step));
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->volume.grid.size[2], 8);
  EXPECT_LT((read->volume.grid.axes.col(2) - step).norm(), decimals);
  // pixels rise by 100 per slice, so interpolation gives the missing slices exactly
  for (int k = 0; k < 8; ++k) EXPECT_EQ(read->volume.at(2, 1, k), stored(k, 1, 2) - 1024) << k;
  EXPECT_TRUE(says(read->warnings, "2 slices are missing (the first behind slice 3)"))
      << read->warnings.front();
}

TEST(Dicom, ResamplesUnevenSpacingWithANote) {
  ScratchFolder folder;
  const std::vector<double> z{0, 3, 6, 9, 13, 17, 21};
  for (std::size_t n = 0; n < z.size(); ++n) {
    TestSlice slice = numbered({}, static_cast<int>(n), {0, 0, 0});
    slice.position.z() += z[n];
    for (auto& p : slice.pixels) p = static_cast<std::uint16_t>(1000 + 10 * z[n]);  // linear in z
    write_slice(folder / shuffled_name(static_cast<int>(n)), slice);
  }
  const auto read = read_volume(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  const Grid& grid = read->volume.grid;
  EXPECT_LT(std::abs(grid.point({0, 0, static_cast<double>(grid.size[2] - 1)}).z() - 51), decimals);
  for (std::int64_t k = 0; k < grid.size[2]; ++k) {
    const double along = grid.point({0, 0, static_cast<double>(k)}).z() - 30;
    EXPECT_LE(std::abs(read->volume.at(0, 0, k) - (1000 + 10 * along - 1024)), 0.5 + 1e-4);
  }
  EXPECT_TRUE(says(read->warnings, "unevenly spaced, 3 mm to 4 mm apart"));
}

// A scaling that is no number must not count as missing: CT numbers would be off by 1024.
TEST(Dicom, RefusesAScalingThatIsNotANumber) {
  for (const auto& [slope, intercept] : std::vector<std::pair<std::string, std::string>>{{"", "x1024"},
                                                                                         {"", "--1024"},
                                                                                         {"", "1e400"},
                                                                                         {"", "-10x4"},
                                                                                         {"one", ""},
                                                                                         {"0", ""},
                                                                                         {"0x10", ""}}) {
    ScratchFolder folder;
    TestSlice slice;
    slice.slope_text = slope, slice.intercept_text = intercept;
    write_series(folder, slice, 3, {0, 0, 3});
    const auto read = read_volume(folder.path());
    ASSERT_FALSE(read) << slope << intercept;
    EXPECT_NE(read.error().message().find("rescale slope or intercept is not a number"), std::string::npos)
        << read.error().message();
  }
  ScratchFolder folder;  // blanks and a sign are valid in numbers
  TestSlice slice;
  slice.intercept_text = " +5.0 ";
  write_series(folder, slice, 3, {0, 0, 3});
  EXPECT_TRUE(read_volume(folder.path()));
}

TEST(Dicom, RefusesFilesThatAreNoVolume) {
  const auto refusal = [](const ScratchFolder& folder, const ReadOptions& options = {}) {
    const auto read = read_volume(folder.path(), options);
    return read ? std::string("was read") : read.error().message();
  };
  ScratchFolder empty, single, wide, twice, crooked, ct, cut, other, multi;
  EXPECT_NE(refusal(empty).find("contains no DICOM images"), std::string::npos);
  write_series(single, {}, 1, {0, 0, 1});
  EXPECT_NE(refusal(single).find("only one slice"), std::string::npos) << refusal(single);

  for (const int k : {0, 1, 2, 20, 21}) write_slice(wide / shuffled_name(k), numbered({}, k, {0, 0, 3}));
  EXPECT_NE(refusal(wide).find("has a gap of 54 mm between the slices"), std::string::npos) << refusal(wide);

  write_series(twice, {}, 4, {0, 0, 3});
  TestSlice again = numbered({}, 2, {0, 0, 3});
  again.instance = "1.2.3.77", again.pixels[0] = 7;
  write_slice(twice / "again.dcm", again);
  EXPECT_NE(refusal(twice).find("two different slices at one position"), std::string::npos) << refusal(twice);

  for (int k = 0; k < 4; ++k)
    write_slice(crooked / shuffled_name(k), numbered({}, k, {k == 2 ? 4.0 : 0.0, 0, 3}));
  EXPECT_NE(refusal(crooked).find("do not lie along one line"), std::string::npos) << refusal(crooked);

  write_series(ct, {}, 3, {0, 0, 3});
  EXPECT_NE(refusal(ct, {FileQuantity::mr, {}}).find("'hu', not 'mr'"), std::string::npos);

  TestSlice pet;
  pet.modality = "PT";
  write_series(other, pet, 3, {0, 0, 3});
  EXPECT_NE(refusal(other).find("modality 'PT'"), std::string::npos) << refusal(other);

  TestSlice frames = numbered({}, 0, {0, 0, 3});
  frames.frames = 4;
  write_slice(multi / "a.dcm", frames);
  EXPECT_NE(refusal(multi).find("multi-frame"), std::string::npos) << refusal(multi);

  write_series(cut, {}, 3, {0, 0, 3});
  auto bytes = file_bytes(cut / shuffled_name(1));
  bytes.resize(bytes.size() - 20);
  put_bytes(cut / shuffled_name(1), bytes);
  EXPECT_NE(refusal(cut).find(shuffled_name(1)), std::string::npos) << refusal(cut);

  EXPECT_NE(read_volume(cut / shuffled_name(0)).error().message().find("give its folder"), std::string::npos);
}

TEST(Dicom, ReadsCopiesOnceAndSeparatesPhases) {
  ScratchFolder copies, phases;
  write_series(copies, {}, 4, {0, 0, 3});
  write_series(copies, {}, 4, {0, 0, 3}, "copy");
  const auto once = read_volume(copies.path());
  ASSERT_TRUE(once) << once.error().message();
  EXPECT_EQ(once->volume.grid.size[2], 4);
  EXPECT_TRUE(says(once->warnings, "4 slices appear twice"));

  for (int k = 0; k < 5; ++k)
    for (const int phase : {1, 2}) {
      if (phase == 2 && k == 4) continue;
      TestSlice slice = numbered({}, k, {0, 0, 3});
      slice.instance += "." + std::to_string(phase), slice.acquisition = std::to_string(phase);
      slice.pixels[0] += phase;  // equal pixels would count as copies
      write_slice(phases / fmt::format("{}{}", phase, k), slice);
    }
  const auto parted = read_volume(phases.path());
  ASSERT_TRUE(parted) << parted.error().message();
  EXPECT_EQ(parted->volume.grid.size[2], 5);
  EXPECT_TRUE(says(
      parted->warnings,
      "found 2 volumes of one series; read the largest CT, CT 'body', acquisition 1 (5 slices of 6 x 5)"))
      << fmt::format("{}", fmt::join(parted->warnings, "\n"));
}

TEST(Dicom, FlippedBytesNeverCrash) {
  ScratchFolder folder;
  write_series(folder, {}, 3, {0, 0, 3});
  const std::string victim = folder / shuffled_name(1);
  const auto whole = file_bytes(victim);
  std::mt19937 random(23);
  int refused = 0;
  for (int round = 0; round < 150; ++round) {
    auto bytes = whole;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      bytes[128 + random() % (bytes.size() - 128)] = static_cast<char>(random());
    put_bytes(victim, bytes);
    const auto read = read_volume(folder.path());
    if (!read) ++refused;
  }
  EXPECT_GT(refused, 10);
}

// From DATA.md and the files' headers (dcmdump): z from 1055 to 1532, 512 x 512 at 1.03 mm, 3 mm apart.
TEST(Dicom, ReadsARealCtOfATrunk) {
  const std::string path = test::shared_folder() + "/volumes/ct_trunk_dicom";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the CT is not there: " << path;
  const auto ct = read_volume(path);
  ASSERT_TRUE(ct) << ct.error().message();
  const Grid& grid = ct->volume.grid;
  EXPECT_EQ(grid.size, (std::array<std::int64_t, 3>{512, 512, 160}));
  EXPECT_LT((grid.axes - Eigen::Matrix3d(Vector3d(1.03, 1.03, 3).asDiagonal())).norm(), 1e-9);
  EXPECT_LT((grid.origin - Vector3d(-276.3671, -263.6718, 1055)).norm(), 1e-9);
  EXPECT_EQ(ct->least, padding_hu);
  EXPECT_TRUE(says(ct->warnings, "are padding, which the scanner did not see"));
  EXPECT_EQ(ct->modality, "CT");
  EXPECT_EQ(ct->pose, "supine");
}

// The codes of PS3.3, C.7.3.1.1.2.
TEST(Dicom, PoseComesFromThePatientPosition) {
  for (const auto& [code, pose] : {std::pair{"HFS", "supine"},
                                   {"FFS", "supine"},
                                   {"HFP", "prone"},
                                   {"FFP", "prone"},
                                   {"HFDL", "on the left side"},
                                   {"FFDR", "on the right side"},
                                   {"XX", ""},
                                   {"", ""}}) {
    ScratchFolder folder;
    TestSlice slice;
    slice.patient_position = code;
    write_series(folder, slice, 3, {0, 0, 2.5});
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->pose, pose) << code;
  }
}

// The same three slices in every encoding that DCMTK writes: implicit and big-endian syntaxes, no preamble,
// sequences of undefined length, RLE and JPEG.
TEST(Dicom, EveryEncodingGivesTheSameVolume) {
  const std::string path = test::shared_folder() + "/volumes/ct_trunk_dicom/";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the CT is not there: " << path;
  if (std::system("command -v dcmconv >/dev/null") != 0)
    GTEST_SKIP() << "dcmconv (package dcmtk) is not there";
  const auto converted = [&](const std::string& command) {
    ScratchFolder folder;
    for (const char* name : {"1-080.dcm", "1-081.dcm", "1-082.dcm"})
      if (std::system((command + " " + path + name + " " + folder / name).c_str()) != 0)
        return Result<ScannedVolume>(failure(command, "failed"));
    return read_volume(folder.path());
  };
  const auto plain = converted("cp");
  ASSERT_TRUE(plain) << plain.error().message();
  ASSERT_EQ(plain->volume.grid.size[2], 3);
  for (const char* command :
       {"dcmconv +ti", "dcmconv +tb", "dcmconv -F +ti", "dcmconv -F +te", "dcmconv -e +te", "dcmconv +e +ti",
        "dcmcrle", "dcmcjpeg +e1", "dcmcjpls", "dcmconv +td"}) {
    const auto other = converted(command);
    ASSERT_TRUE(other) << command << ": " << other.error().message();
    EXPECT_EQ(other->volume.grid, plain->volume.grid) << command;
    EXPECT_EQ(other->volume.voxels, plain->volume.voxels) << command;
  }
}

TEST(Dicom, DecompressesARealMrOfAKnee) {
  const std::string path = test::shared_folder() + "/volumes/mr_knee_dicom";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the MR is not there: " << path;
  const auto mr = read_volume(path);
  ASSERT_TRUE(mr) << mr.error().message();
  EXPECT_EQ(mr->volume.grid.size, (std::array<std::int64_t, 3>{384, 384, 24}));
  EXPECT_NEAR(mr->volume.grid.spacing()[0], 0.44270834, 1e-6);
  EXPECT_NEAR(mr->volume.grid.spacing()[2], 4.29, 0.005);  // DATA.md rounds to 0.01
  EXPECT_EQ(mr->volume.quantity, Quantity::mr);
  EXPECT_EQ(mr->format, "DICOM, 24 slices, packed as JPEG lossless");

  // DCMTK's own decoder
  if (std::system("command -v dcmdjpeg >/dev/null") != 0)
    GTEST_SKIP() << "dcmdjpeg (package dcmtk) is not there";
  ScratchFolder plain;
  for (const auto& file : std::filesystem::directory_iterator(path)) {
    const std::string name = file.path().filename().string();
    ASSERT_EQ(std::system(("dcmdjpeg '" + file.path().string() + "' '" + plain / name + "'").c_str()), 0);
  }
  const auto unpacked = read_volume(plain.path());
  ASSERT_TRUE(unpacked) << unpacked.error().message();
  EXPECT_EQ(unpacked->format, "DICOM, 24 slices");
  EXPECT_EQ(unpacked->volume.grid, mr->volume.grid);
  EXPECT_EQ(unpacked->volume.voxels, mr->volume.voxels);
}

}  // namespace
}  // namespace borelli
