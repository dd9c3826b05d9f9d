// Multi-frame DICOM: enhanced CT and MR as volumes, DICOM-SEG as label maps. The files are built here element
// by element after PS3.5 and PS3.3; GDCM reads one of each kind as a check.
#include <gdcmImageReader.h>
#include <gdcmTrace.h>
#include <gtest/gtest.h>

#include "scratch_folder.hpp"
#include "segmentation/files/dicom_segmentation.hpp"
#include "segmentation/files/read.hpp"
#include "test_data_set.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr int columns = 5, rows = 4;

std::string numbers(const Vector3d& v) {
  return std::to_string(v[0]) + "\\" + std::to_string(v[1]) + "\\" + std::to_string(v[2]);
}

DataSet position(const Vector3d& at, bool undefined) {
  return DataSet().sequence(0x00209113, {DataSet().add(0x00200032, "DS", numbers(at))}, undefined);
}

struct Enhanced {
  std::string modality = "CT";
  int frames = 6, described = 6;
  bool undefined = false;        // lengths of sequences
  bool scaled_by_frame = false;  // rescaling in each frame's group, not in the shared one
  Vector3d step{0, 0, 2.5};
};

// Frame n of the file is slice 5 n mod frames, so the order in the file means nothing.
int place_of(const Enhanced& e, int n) { return 5 * n % e.frames; }
int stored(int place, int row, int column) { return 1000 + 100 * place + 10 * row + column; }

void write(const std::string& path, const Enhanced& e) {
  const std::string sop = e.modality == "CT" ? "1.2.840.10008.5.1.4.1.1.2.1" : "1.2.840.10008.5.1.4.1.1.4.1";
  const auto scaling = [&](double slope) {
    return DataSet()
        .add(0x00281052, "DS", "-1024")
        .add(0x00281053, "DS", std::to_string(slope))
        .add(0x00281054, "LO", "HU");
  };
  DataSet shared;
  shared.sequence(0x00209116, {DataSet().add(0x00200037, "DS", "1\\0\\0\\0\\1\\0")}, e.undefined);
  shared.sequence(0x00289110, {DataSet().add(0x00180050, "DS", "2.5").add(0x00280030, "DS", "0.5\\0.75")},
                  e.undefined);
  if (!e.scaled_by_frame) shared.sequence(0x00289145, {scaling(1)}, e.undefined);
  std::vector<DataSet> frames;
  std::string pixels;
  for (int n = 0; n < e.frames; ++n) {
    const int place = place_of(e, n);
    DataSet frame = position(Vector3d(-10, -20, 30) + place * e.step, e.undefined);
    if (e.scaled_by_frame) frame.sequence(0x00289145, {scaling(place % 2 ? 0.5 : 1)}, e.undefined);
    if (n < e.described) frames.push_back(frame);
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        pixels += DataSet::raw(static_cast<std::uint16_t>(stored(place, row, column)));
  }
  DataSet file;
  file.add(0x00080016, "UI", sop).add(0x00080018, "UI", "1.2.3.4").add(0x00080060, "CS", e.modality);
  file.add(0x0020000e, "UI", "1.2.3").number(0x00280002, 1).add(0x00280004, "CS", "MONOCHROME2");
  file.add(0x00280008, "IS", std::to_string(e.frames)).number(0x00280010, rows).number(0x00280011, columns);
  file.number(0x00280100, 16).number(0x00280101, 16).number(0x00280102, 15).number(0x00280103, 0);
  file.sequence(0x52009229, {shared}, e.undefined).sequence(0x52009230, frames, e.undefined);
  file.add(0x7fe00010, "OW", pixels);
  file.write(path, sop);
}

TEST(DicomFrames, EnhancedCtIsAVolume) {
  for (const bool undefined : {false, true})
    for (const bool by_frame : {false, true}) {
      const ScratchFolder folder;
      const Enhanced e{.undefined = undefined, .scaled_by_frame = by_frame};
      write(folder / "a.dcm", e);
      for (const std::string& path : {folder / "a.dcm", folder.path()}) {
        const auto read = read_volume(path);
        ASSERT_TRUE(read) << read.error().message();
        const Grid& g = read->volume.grid;
        ASSERT_EQ(g.size, (std::array<std::int64_t, 3>{columns, rows, e.frames}));
        EXPECT_LT((g.axes - Eigen::Matrix3d(Vector3d(0.75, 0.5, 2.5).asDiagonal())).norm(), 1e-5);
        EXPECT_LT((g.origin - Vector3d(-10, -20, 30)).norm(), 1e-5);
        EXPECT_EQ(read->volume.quantity, Quantity::hu);
        EXPECT_EQ(read->modality, "CT");
        for (int k = 0; k < e.frames; ++k)
          for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i) {
              const double slope = by_frame && k % 2 ? 0.5 : 1;
              EXPECT_LE(std::abs(read->volume.at(i, j, k) - (slope * stored(k, j, i) - 1024)), 0.5);
            }
      }
    }
}

TEST(DicomFrames, GdcmReadsTheSameFile) {
  const ScratchFolder folder;
  write(folder / "a.dcm", {});
  gdcm::Trace::WarningOff(),
      gdcm::Trace::ErrorOff();  // silences its complaint about uneven spacing, as the frames are not in order
  gdcm::ImageReader reader;
  reader.SetFileName((folder / "a.dcm").c_str());
  const bool gdcm_read = reader.Read();
  gdcm::Trace::ErrorOn();
  ASSERT_TRUE(gdcm_read);
  const gdcm::Image& image = reader.GetImage();
  EXPECT_EQ(image.GetDimension(2), 6U);
  std::vector<std::uint16_t> pixels(image.GetBufferLength() / 2);
  ASSERT_TRUE(image.GetBuffer(reinterpret_cast<char*>(pixels.data())));
  const auto read = read_volume(folder / "a.dcm");
  ASSERT_TRUE(read) << read.error().message();
  const Enhanced e;
  for (int n = 0; n < e.frames; ++n)
    for (int o = 0; o < rows * columns; ++o)
      EXPECT_EQ(read->volume.voxels[static_cast<std::size_t>(place_of(e, n) * rows * columns + o)],
                pixels[static_cast<std::size_t>(n * rows * columns + o)] - 1024);
}

TEST(DicomFrames, ReadsEnhancedMrAndReportsErrors) {
  const ScratchFolder folder;
  write(folder / "mr.dcm", {.modality = "MR"});
  const auto mr = read_volume(folder / "mr.dcm");
  ASSERT_TRUE(mr) << mr.error().message();
  EXPECT_EQ(mr->volume.quantity, Quantity::mr);

  write(folder / "few.dcm", {.described = 4});
  const auto few = read_volume(folder / "few.dcm");
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message().find("it has 6 frames and describes 4"), std::string::npos)
      << few.error().message();

  auto bytes = file_bytes(folder / "mr.dcm");
  bytes.resize(bytes.size() - 50);
  put_bytes(folder / "cut.dcm", bytes);
  EXPECT_FALSE(read_volume(folder / "cut.dcm"));
}

// Segments 1 (a block) and 2 (an overlapping block); empty frames of 2 are omitted.
struct Segments {
  std::string type = "BINARY";
  bool undefined = false;
};
bool in_first(int i, int j, int k) { return i < 3 && j < 3 && k < 4; }
bool in_second(int i, int j, int k) { return i > 1 && j > 0 && k > 1; }

void write(const std::string& path, const Segments& s) {
  const int slices = 5;
  const bool binary = s.type == "BINARY";
  std::vector<DataSet> frames;
  std::vector<int> values;
  for (int segment = 1; segment <= 2; ++segment)
    for (int k = segment == 2 ? 2 : 0; k < slices; ++k) {
      DataSet frame = position(Vector3d(-10, -20, 30) + k * Vector3d(0.2, 0, 3), s.undefined);
      frame.sequence(0x0062000a, {DataSet().number(0x0062000b, static_cast<std::uint16_t>(segment))},
                     s.undefined);
      frames.push_back(frame);
      for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
          const bool inside = segment == 1 ? in_first(i, j, k) : in_second(i, j, k);
          // fractions: the second segment fades to its right
          values.push_back(binary ? inside : !inside ? 40 : segment == 1 ? 180 : 200 - 30 * (4 - i));
        }
    }
  std::string pixels;
  if (binary) {  // bits, the lowest first, frames without gaps between them
    pixels.assign((values.size() + 7) / 8, '\0');
    for (std::size_t n = 0; n < values.size(); ++n)
      pixels[n / 8] = static_cast<char>(pixels[n / 8] | values[n] << n % 8);
  } else {
    for (const int v : values) pixels += static_cast<char>(v);
  }
  DataSet shared;
  shared.sequence(0x00209116, {DataSet().add(0x00200037, "DS", "1\\0\\0\\0\\1\\0")}, s.undefined);
  shared.sequence(
      0x00289110,
      {DataSet().add(0x00180050, "DS", "3").add(0x00180088, "DS", "3").add(0x00280030, "DS", "0.5\\0.75")},
      s.undefined);
  std::vector<DataSet> segments;
  for (int n = 1; n <= 2; ++n)
    segments.push_back(DataSet()
                           .number(0x00620004, static_cast<std::uint16_t>(n))
                           .add(0x00620005, "LO", n == 1 ? "Femur left" : "Skin"));
  DataSet file;
  const auto bits = static_cast<std::uint16_t>(binary ? 1 : 8);
  file.add(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
      .add(0x00080018, "UI", "1.2.3.5")
      .add(0x00080060, "CS", "SEG");
  file.add(0x0020000e, "UI", "1.2.9").number(0x00280002, 1).add(0x00280004, "CS", "MONOCHROME2");
  file.add(0x00280008, "IS", std::to_string(frames.size()))
      .number(0x00280010, rows)
      .number(0x00280011, columns);
  file.number(0x00280100, bits)
      .number(0x00280101, bits)
      .number(0x00280102, static_cast<std::uint16_t>(bits - 1));
  file.number(0x00280103, 0).add(0x00620001, "CS", s.type).sequence(0x00620002, segments, s.undefined);
  if (!binary) file.number(0x0062000e, 200).add(0x00620010, "CS", "PROBABILITY");
  file.sequence(0x52009229, {shared}, s.undefined).sequence(0x52009230, frames, s.undefined);
  file.add(0x7fe00010, "OB", pixels);
  file.write(path, "1.2.840.10008.5.1.4.1.1.66.4");
}

TEST(DicomFrames, SegmentationsAreLabelMaps) {
  for (const std::string type : {"BINARY", "FRACTIONAL"})
    for (const bool undefined : {false, true}) {
      const ScratchFolder folder;
      write(folder / "seg.dcm", Segments{type, undefined});
      for (const std::string& path : {folder / "seg.dcm", folder.path()}) {
        const auto read = read_numbered_labels(path);
        ASSERT_TRUE(read) << read.error().message();
        const Grid& g = read->map.grid;
        ASSERT_EQ(g.size, (std::array<std::int64_t, 3>{columns, rows, 5}));
        EXPECT_LT((g.origin - Vector3d(-10, -20, 30)).norm(), 1e-5);
        // sheared frames: 0.2 mm sideways per slice
        EXPECT_LT((g.axes.col(2) - Vector3d(0.2, 0, 3)).norm(), 1e-5);
        ASSERT_EQ(read->map.names.size(), 3U);
        EXPECT_EQ(read->map.names[1], "Femur left");
        EXPECT_EQ(read->map.names[2], "Skin");
        for (int k = 0; k < 5; ++k)
          for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i) {
              const bool one = in_first(i, j, k), two = in_second(i, j, k);
              int expected = two ? 2 : one ? 1 : 0;
              if (type == "FRACTIONAL") {
                // 100 of 200 is half; of two the larger fraction: 180 beside 140 at i = 2
                const int of_two = two ? 200 - 30 * (4 - i) : 40, of_one = one ? 180 : 40;
                expected = of_one < 100 && of_two < 100 ? 0 : of_two >= of_one ? 2 : 1;
              }
              EXPECT_EQ(read->map.at(i, j, k), expected) << type << i << j << k;
            }
      }
      const auto volume = read_volume(folder / "seg.dcm");
      ASSERT_FALSE(volume);
      EXPECT_NE(volume.error().message().find("contains a DICOM segmentation but no scan"), std::string::npos)
          << volume.error().message();
    }
}

TEST(DicomFrames, RefusesDamagedSegmentations) {
  const ScratchFolder folder;
  write(folder / "seg.dcm", Segments{"BINARY", true});
  const auto whole = file_bytes(folder / "seg.dcm");
  for (std::size_t cut = 200; cut < whole.size() - 2; cut += 7) {  // anywhere
    auto bytes = whole;
    bytes.resize(cut);
    put_bytes(folder / "cut.dcm", bytes);
    EXPECT_FALSE(read_labels(folder / "cut.dcm")) << cut;
  }
  const std::string text(whole.begin(), whole.end());
  const auto spoiled = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    put_bytes(folder / "bad.dcm", {other.begin(), other.end()});
    const auto read = read_labels(folder / "bad.dcm");
    return read ? std::string("read") : read.error().message();
  };
  EXPECT_NE(spoiled("BINARY", "SURELY").find("type 'SURELY'"), std::string::npos);
  EXPECT_NE(spoiled("-9.800000", "-7.800000").find("not evenly spaced along one line"), std::string::npos);
}

// A segmentation's frames are 5 slices of 5 x 4 pixels; its header shows whether that can be the scan's grid.
TEST(DicomFrames, HeaderGivesTheGridOfASegmentation) {
  const ScratchFolder folder;
  write(folder / "seg.dcm", Segments{"BINARY", true});
  Grid scan{{9, 8, 12}, Eigen::Matrix3d(Vector3d(0.75, 0.5, 3).asDiagonal()), Vector3d(-10.75, -21, 24)};
  scan.axes(0, 2) = 0.2;
  scan.origin.x() -= 2 * 0.2;
  const auto answer = [&](const Grid& grid) {
    const auto fits = read_labels(folder / "seg.dcm", "", {}, &grid);
    return fits ? "fits" : fits.error().message();
  };
  EXPECT_EQ(answer(scan), "fits");
  Grid turned = scan;  // rows for columns, slices from above
  turned.size = {12, 9, 8};
  turned.axes.col(0) = -scan.axes.col(2), turned.axes.col(1) = scan.axes.col(0);
  turned.axes.col(2) = scan.axes.col(1);
  turned.origin = scan.point(0, 0, 11);
  EXPECT_EQ(answer(turned), "fits");
  Grid shifted = scan, coarse = scan;
  shifted.origin.z() += 1;
  coarse.axes.col(0) *= 2;
  for (const Grid& other : {shifted, coarse})
    EXPECT_TRUE(answer(other).starts_with(folder / "seg.dcm" + ": lies on another grid (")) << answer(other);
}

// Two frames 4 m apart, in a file of 66 kB.
TEST(DicomFrames, RefusesSegmentationsLongerThanABody) {
  const std::string path = test::shared_folder() + "/cases/seg_bomb.dcm";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the case is not there: " << path;
  const auto read = read_labels(path);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("frames that span 4000 mm, more than any body"), std::string::npos)
      << read.error().message();
}

}  // namespace
}  // namespace borelli
