// In every format, scans that cannot show a person are refused and doubtful ones are reported. Partial scans,
// children, water phantoms and densities pass.
#include "segmentation/files/plausibility.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <random>

#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "tests/segmentation/dicom_series.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli::plausibility_test {
namespace {

using Change = std::function<int(int)>;

const Scan& body() {
  static const Scan made = [] {
    const Phantom phantom = build_phantom({}).value();
    GridOptions grid;
    grid.spacing.setConstant(10);
    ScanOptions scan;
    scan.noise_hu = 60;
    return voxelise(phantom, phantom_grid(phantom, grid), scan);
  }();
  return made;
}

std::vector<std::int32_t> changed(const GreyVolume& volume, const Change& change) {
  std::vector<std::int32_t> values;
  for (const auto v : volume.voxels) values.push_back(change(v));
  return values;
}

const std::vector<std::string> formats{"a.nii", "a.nrrd", "a.mha", "slices"};

std::string nifti_header(const Grid& grid) {
  std::string bytes(352, 0);
  const auto set = [&](std::size_t offset, auto value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
  };
  set(0, std::int32_t{348}), set(40, std::int16_t{3}), set(70, std::int16_t{8}), set(72, std::int16_t{32});
  set(108, 352.F), set(254, std::int16_t{1});
  for (std::size_t c = 0; c < 3; ++c) {
    set(42 + 2 * c, static_cast<std::int16_t>(grid.size[c]));
    set(80 + 4 * c, static_cast<float>(grid.spacing()[static_cast<int>(c)]));
    set(280 + 20 * c, static_cast<float>(grid.spacing()[static_cast<int>(c)]));
  }
  bytes[123] = 2;
  bytes.replace(148, 10, "borelli hu"), bytes.replace(344, 3, "n+1");
  return bytes;
}

std::string text_header(const std::string& format, const Grid& grid) {
  const auto& n = grid.size;
  const Eigen::Vector3d d = grid.spacing();
  if (format == "a.nrrd")
    return fmt::format(
        "NRRD0005\ntype: int\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\nspace "
        "directions: ({},0,0) (0,{},0) (0,0,{})\nencoding: raw\nendian: little\nborelli "
        "quantity:=hu\n\n",
        n[0], n[1], n[2], d[0], d[1], d[2]);
  return fmt::format(
      "NDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nElementSpacing = {} {} {}\nDimSize "
      "= {} {} {}\nElementType = MET_INT\nComment = borelli hu\nElementDataFile = LOCAL\n",
      d[0], d[1], d[2], n[0], n[1], n[2]);
}

// Values as int32; in DICOM as the low 16 bits, signed where one of them is, without a rescaling.
void write_as(const ScratchFolder& folder, const std::string& format, const Grid& grid,
              const std::vector<std::int32_t>& values) {
  if (format != "slices") {
    std::string bytes = format == "a.nii" ? nifti_header(grid) : text_header(format, grid);
    bytes.append(reinterpret_cast<const char*>(values.data()), 4 * values.size());
    put_bytes(folder / format, {bytes.begin(), bytes.end()});
    return;
  }
  std::filesystem::create_directories(folder / format);
  const bool is_signed = *std::ranges::min_element(values) < 0;
  const auto area = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
  for (std::int64_t k = 0; k < grid.size[2]; ++k) {
    TestSlice slice;
    slice.columns = static_cast<int>(grid.size[0]), slice.rows = static_cast<int>(grid.size[1]);
    slice.column_spacing = slice.row_spacing = 10, slice.bits_stored = 16;
    slice.is_signed = is_signed;
    slice.position += Eigen::Vector3d(0, 0, 10 * static_cast<double>(k));
    slice.instance = slice.series + "." + std::to_string(k + 1);
    slice.intercept = 0;
    for (std::size_t n = 0; n < area; ++n)
      slice.pixels.push_back(static_cast<std::uint16_t>(values[static_cast<std::size_t>(k) * area + n]));
    write_slice(folder / (format + fmt::format("/{:03}.dcm", k)), slice);
  }
}

Result<ScannedVolume> read(const std::string& format, const GreyVolume& volume, const Change& change) {
  ScratchFolder folder;
  write_as(folder, format, volume.grid, changed(volume, change));
  return read_volume(folder / format);
}

void expect_refused(const Result<ScannedVolume>& read, const std::string& sentence, const std::string& of) {
  ASSERT_FALSE(read) << of;
  EXPECT_NE(read.error().message().find(sentence), std::string::npos) << of << ": " << read.error().message();
}

TEST(Plausibility, RefusesUnscaledCtNumbersInEveryFormat) {
  for (const std::string& format : formats) {
    expect_refused(read(format, body().grey, [](int v) { return v + 1024; }), "with 1000 or 1024 added",
                   format);
    expect_refused(read(format, body().grey, [](int v) { return v + 1000; }), "with 1000 or 1024 added",
                   format);
  }
}

TEST(Plausibility, RefusesSignedPixelsDeclaredUnsignedInEveryFormat) {
  for (const std::string& format : formats)
    for (const int bits : {12, 16})
      expect_refused(read(format, body().grey, [&](int v) { return v & ((1 << bits) - 1); }),
                     "signed numbers were stored as unsigned", format + ", " + std::to_string(bits));
}

TEST(Plausibility, RefusesManyOutOfRangeValues) {
  std::mt19937 random(3);
  // an intercept applied twice, with noise around air; a slope of 50
  expect_refused(
      read("a.nii", body().grey, [&](int v) { return v - 1024 - static_cast<int>(random() % 50); }),
      "check whether the intercept was applied twice", "twice");
  expect_refused(read("a.nii", body().grey, [](int v) { return 1000 * v + 40000; }),
                 "is not a volume of CT numbers", "slope");
  expect_refused(read("a.nii", body().grey, [](int v) { return 2 * v; }), "below -1100, lower than air",
                 "slope of 2");
  // a few such voxels are reported
  const auto few = read("a.nii", body().grey, [&](int v) { return random() % 100 == 0 ? 40000 : v; });
  ASSERT_TRUE(few) << few.error().message();
  ASSERT_FALSE(few->warnings.empty());
  EXPECT_NE(few->warnings[0].find("above 32767"), std::string::npos) << few->warnings[0];
}

// Air where no air is: refused, but where lungs may be. An offset that leaves air near -1000 is not seen.
TEST(Plausibility, JudgesCtNumbersByTheirAir) {
  for (const std::string& format : formats) {
    expect_refused(read(format, body().grey, [](int v) { return v / 2; }), "but air has -1000", format);
    expect_refused(read(format, body().grey, [](int v) { return v + 500; }), "but air has -1000", format);
    expect_refused(read(format, body().grey, [](int v) { return v - 300; }), "lower than air", format);
    const auto told = read(format, body().grey, [](int v) { return v + 300; });
    ASSERT_TRUE(told) << told.error().message();
    ASSERT_FALSE(told->warnings.empty()) << format;
    EXPECT_NE(told->warnings[0].find("hardly any of the voxels below tissue lie near -1000"),
              std::string::npos)
        << told->warnings[0];
    const auto silent = read(format, body().grey, [](int v) { return v + 30; });
    ASSERT_TRUE(silent) << silent.error().message();
  }
}

TEST(Plausibility, RefusesNegativeDensities) {
  GreyVolume densities = body().grey;
  densities.quantity = Quantity::density_kgm3;
  for (auto& v : densities.voxels) v = static_cast<std::int16_t>(std::max(v + 1000, 0));
  const auto read_less = [&](int by) {
    ScratchFolder folder;
    write_as(folder, "a.nii", densities.grid, changed(densities, [&](int v) { return v - by; }));
    return read_volume(folder / "a.nii", {FileQuantity::density_kgm3, {}});
  };
  EXPECT_TRUE(read_less(0)) << read_less(0).error().message();
  expect_refused(read_less(200), "are below -100 kg/m3", "200 too little");
}

// CT numbers clipped to a viewer's window, also as an image of 8 bits: refused with advice.
TEST(Plausibility, RefusesDisplayWindowsInEveryFormat) {
  for (const std::string& format : formats) {
    for (const auto& [low, high] : {std::pair{-200, 300}, {-160, 240}, {-150, 250}, {-450, 1050}})
      expect_refused(read(format, body().grey, [&](int v) { return std::clamp(v, low, high); }),
                     "lower values were cut off (by a display window", format);
    expect_refused(read(format, body().grey, [](int v) { return std::clamp((v + 200) * 255 / 500, 0, 255); }),
                   "an 8-bit picture", format);
    const auto told = read(format, body().grey, [](int v) { return std::min(v, 300); });
    ASSERT_TRUE(told) << told.error().message();
    ASSERT_FALSE(told->warnings.empty()) << format;
    EXPECT_NE(told->warnings[0].find("denser bone was cut off"), std::string::npos) << told->warnings[0];
  }
}

GreyVolume cropped(std::array<std::int64_t, 3> first, std::array<std::int64_t, 3> size) {
  const GreyVolume& whole = body().grey;
  GreyVolume out;
  out.grid = whole.grid;
  out.grid.size = size;
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i)
        out.voxels.push_back(whole.at(first[0] + i, first[1] + j, first[2] + k));
  return out;
}

TEST(Plausibility, AcceptsWholeAndPartialScans) {
  const auto same = [](int v) { return v; };
  for (const std::string& format : formats) {
    const auto whole = read(format, body().grey, same);
    ASSERT_TRUE(whole) << whole.error().message();
    for (const std::string& warning : whole->warnings)
      EXPECT_EQ(warning.find("air"), std::string::npos) << warning;
  }
  // inside a thigh, without air: doubted
  const auto& g = body().grey.grid;
  const Landmarks marks = build_phantom({}).value().landmarks;
  const Eigen::Vector3d thigh = g.index(0.5 * (marks.at("hip_left").point + marks.at("knee_left").point));
  const auto inside =
      cropped({std::lround(thigh[0]) - 2, std::lround(thigh[1]) - 2, std::lround(thigh[2]) - 8}, {5, 5, 17});
  const auto tissue = read("a.nii", inside, same);
  ASSERT_TRUE(tissue) << tissue.error().message();
  ASSERT_EQ(tissue->warnings.size(), 1u);
  EXPECT_NE(tissue->warnings[0].find("no value is below -200"), std::string::npos) << tissue->warnings[0];
  // a knee with air around it
  const Eigen::Vector3d knee = g.index(marks.at("knee_left").point);
  const auto about = cropped({std::lround(knee[0]) - 4, 0, std::lround(knee[2]) - 9},
                             {g.size[0] - std::lround(knee[0]) + 4, g.size[1], 18});
  const auto joint = read("a.nii", about, same);
  ASSERT_TRUE(joint) << joint.error().message();
  EXPECT_TRUE(joint->warnings.empty()) << joint->warnings[0];
  // water in air, and densities
  GreyVolume water = body().grey;
  for (auto& v : water.voxels) v = v < -500 ? std::int16_t{-1000} : std::int16_t{0};
  const auto phantom = read("a.nii", water, same);
  ASSERT_TRUE(phantom) << phantom.error().message();
  EXPECT_TRUE(phantom->warnings.empty()) << phantom->warnings[0];
}

TEST(Plausibility, DoubtsImplausibleVoxelAndBodySizes) {
  Grid grid;
  grid.size = {300, 300, 500};
  EXPECT_EQ(doubt_of_size(grid), "");
  grid.axes *= 10;  // 5 m
  EXPECT_NE(doubt_of_size(grid).find("are 5 m"), std::string::npos) << doubt_of_size(grid);
  grid.axes *= 10;
  EXPECT_NE(doubt_of_size(grid).find("check the unit"), std::string::npos);
  grid.axes *= 1e-6;
  EXPECT_NE(doubt_of_size(grid).find("check the unit"), std::string::npos);

  EXPECT_EQ(doubt_of_body(0.0757, 75.8), "");
  EXPECT_EQ(doubt_of_body(0.0757), "");
  EXPECT_EQ(doubt_of_body(0.0031, 3.2), "");  // a newborn
  EXPECT_NE(doubt_of_body(0.0012, 1.2).find("has 1.2 kg, which is impossible for a whole person"),
            std::string::npos);
  EXPECT_NE(doubt_of_body(0.23, 225).find("has 225 kg, more than nearly anyone"), std::string::npos);
  EXPECT_NE(doubt_of_body(0.47, 469, false).find("has 469 kg, which is impossible"), std::string::npos);
  EXPECT_EQ(doubt_of_body(0.0012, 1.2, false), "");  // a hand
  EXPECT_EQ(doubt_of_part("thigh_left", 0.02), "");
  EXPECT_NE(doubt_of_part("thigh_left", 0.17).find("is 170 l large"), std::string::npos);
  EXPECT_EQ(doubt_of_part("tumour", 0.17), "");
  EXPECT_NE(doubt_of_body(0.7).find("has 700 l, which is impossible for a whole person"), std::string::npos);
  EXPECT_NE(doubt_of_body(0.0757, 118.6).find("has 1.57 kg/l"), std::string::npos);
}

// Labels are also warned of if their grid is doubtful.
TEST(Plausibility, DoubtsLabelsWithImplausibleVoxels) {
  ScratchFolder folder;
  LabelMap map;
  map.grid.size = {4, 4, 4};
  map.grid.axes *= 2000;
  map.voxels.assign(64, 1);
  map.names = {"outside", "head"};
  ASSERT_TRUE(write_labels(folder / "l.nrrd", map));
  const auto back = read_labels(folder / "l.nrrd");
  ASSERT_TRUE(back) << back.error().message();
  ASSERT_EQ(back->warnings.size(), 1u);
  EXPECT_NE(back->warnings[0].find("check the unit"), std::string::npos);
}

}  // namespace
}  // namespace borelli::plausibility_test
