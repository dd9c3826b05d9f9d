// Labels written as DICOM segmentations: our reader, pydicom and DCMTK read them, and dciodvfy of dicom3tools
// finds no fault.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/dicom_labels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/terminology.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/paths.hpp"
#include "tests/segmentation/dicom_series.hpp"
#include "tests/segmentation/grids.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli::dicom_labels_test {
namespace {

using nlohmann::json;

struct Said {
  int status = -1;
  std::string text;  // both streams
};

Said run(const std::string& command) {
  Said said;
  std::FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer;
  for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    said.text.append(buffer.data(), n);
  said.status = pclose(pipe);
  return said;
}

class DicomLabelsInDcmtk : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v dcm2json dcmdump dcmodify >/dev/null") != 0)
      GTEST_SKIP() << "needs dcm2json, dcmdump and dcmodify (package dcmtk)";
  }
};

/// The data set by DCMTK, as JSON by tag ("00080060").
json dcmtk_json(const std::string& path) { return json::parse(run("dcm2json " + path).text); }
json value_of(const json& set, const std::string& tag) { return set.at(tag).at("Value").at(0); }
std::string text_of(const json& set, const std::string& tag) {
  const json value = set.contains(tag) && set.at(tag).contains("Value") ? value_of(set, tag) : json("");
  return (value.is_object() ? value.at("Alphabetic") : value).get<std::string>();
}

/// Parts, a class of TotalSegmentator and an unknown name, with an empty slice between others; 35 pixels a
/// frame, so that frames begin within bytes.
LabelMap some_labels(const Grid& grid) {
  LabelMap labels;
  labels.grid = grid;
  labels.names = {"outside", "head", "", "", "", "", "", "", "", "", "", "thigh_left"};
  labels.names.resize(31);
  labels.names[17] = "femur_left", labels.names[30] = "my knee";
  labels.voxels.assign(grid.count(), 0);
  std::mt19937 random(3);
  constexpr std::array<std::uint8_t, 6> choices{0, 0, 1, 11, 17, 30};
  for (auto& voxel : labels.voxels) voxel = choices[random() % choices.size()];
  const std::size_t area = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
  std::fill_n(labels.voxels.begin() + static_cast<std::ptrdiff_t>(2 * area), area, std::uint8_t{0});
  return labels;
}

Grid grid_of(bool mirrored, double tilt) {
  Grid grid = oblique_grid(mirrored, tilt);
  grid.size[2] = 6;
  return grid;
}

std::string written(const ScratchFolder& folder, const LabelMap& labels,
                    const DicomLabelOptions& options = {}, const std::string& name = "labels.dcm") {
  const auto done = write_dicom_labels(folder / name, labels, options);
  EXPECT_TRUE(done) << done.error().message();
  return folder / name;
}

// ---- voxels and places ----

TEST(DicomLabels, ReadBackVoxelForVoxel) {
  for (const bool mirrored : {false, true})
    for (const double tilt : {0.0, 1.75}) {  // gantry tilt: slices shift sideways
      const ScratchFolder folder;
      const LabelMap labels = some_labels(grid_of(mirrored, tilt));
      const auto back = read_labels(written(folder, labels), "", {}, &labels.grid);
      ASSERT_TRUE(back) << back.error().message();
      for (std::size_t n = 0; n < labels.voxels.size(); ++n)
        ASSERT_EQ(back->names[back->voxels[n]], labels.names[labels.voxels[n]]) << n;
      // positions to the digits of a decimal string; our reader orders slices along their normal
      const auto bare = read_labels(folder / "labels.dcm");
      ASSERT_TRUE(bare) << bare.error().message();
      const std::int64_t last = labels.grid.size[2] - 1;
      EXPECT_LT((bare->grid.point(0, 0, 0) - labels.grid.point(0, 0, mirrored ? last : 0)).norm(), 1e-9);
      EXPECT_LT((bare->grid.point(4, 6, last) - labels.grid.point(4, 6, mirrored ? 0 : last)).norm(), 1e-9);
    }
}

// An adjacent table of names belongs to labels.nii.gz, not to this file.
TEST(DicomLabels, KeepTheirNamesBesideATableOfNames) {
  const ScratchFolder folder;
  const LabelMap labels = some_labels(grid_of(false, 0));
  put_bytes(folder / "labels.tsv",
            {'l', 'a', 'b', 'e', 'l', '\t', 'n', 'a', 'm', 'e', '\n', '1', '\t', 'x', '\n'});
  const auto back = read_labels(written(folder, labels), "", {}, &labels.grid);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->names[11], "thigh_left");
}

TEST(DicomLabels, HaveTheSamePixelsAtTheSamePlacesInPydicom) {
  if (std::system("/usr/bin/python3 -c 'import numpy, pydicom' 2>/dev/null") != 0)
    GTEST_SKIP() << "needs python3 with pydicom";
  const ScratchFolder folder;
  const LabelMap labels = some_labels(grid_of(true, 1.75));
  const Said said = run("/usr/bin/python3 " + test::source_folder() +
                        "/tests/segmentation/files/dicom_labels_read.py " + written(folder, labels));
  ASSERT_EQ(said.status, 0) << said.text;
  std::istringstream lines(said.text);
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const std::string name = line.substr(0, line.find('\t'));
    std::istringstream numbers(line.substr(name.size() + 1));
    Eigen::Vector3d point;
    numbers >> point[0] >> point[1] >> point[2];
    const Eigen::Vector3d index = labels.grid.index(point);
    const Eigen::Vector3d whole = index.array().round();
    ASSERT_LT((index - whole).norm(), 1e-9) << line;
    const auto voxel = labels.at(std::lround(whole[0]), std::lround(whole[1]), std::lround(whole[2]));
    ASSERT_EQ(labels.names[voxel], name) << line;
  }
  EXPECT_EQ(count, labels.voxels.size() -
                       static_cast<std::size_t>(std::count(labels.voxels.begin(), labels.voxels.end(), 0)));
}

// ---- elements ----

TEST_F(DicomLabelsInDcmtk, LeaveOutEmptySlices) {
  const ScratchFolder folder;
  const json set = dcmtk_json(written(folder, some_labels(grid_of(false, 0))));
  EXPECT_EQ(set.at("00620002").at("Value").size(), 4U);  // segments
  const json& frames = set.at("52009230").at("Value");
  EXPECT_EQ(frames.size(), 20U);  // 4 segments, all slices except the third
  EXPECT_EQ(value_of(set, "00280008"), 20);
  for (const json& frame : frames) EXPECT_NE(value_of(frame, "00209111").at("00209157").at("Value").at(1), 3);
}

TEST_F(DicomLabelsInDcmtk, CodeEachSegment) {
  const ScratchFolder folder;
  const json set = dcmtk_json(written(folder, some_labels(grid_of(false, 0))));
  const auto term = [](const json& item, const std::string& tag) {
    const json own = value_of(item, tag);
    return text_of(own, "00080102") + " " + text_of(own, "00080100") + " " + text_of(own, "00080104");
  };
  const json& segments = set.at("00620002").at("Value");
  EXPECT_EQ(text_of(segments[0], "00620005"), "head");
  EXPECT_EQ(term(segments[0], "0062000F"), "SCT 774007 Head and Neck");
  EXPECT_FALSE(value_of(segments[0], "0062000F").contains("00620011"));
  EXPECT_EQ(term(segments[1], "0062000F"), "SCT 68367000 Thigh");
  EXPECT_EQ(term(value_of(segments[1], "0062000F"), "00620011"), "SCT 7771000 Left");
  EXPECT_EQ(term(segments[1], "00620003"), "SCT 123037004 Anatomical Structure");
  EXPECT_EQ(term(segments[2], "0062000F"), "SCT 71341001 Femur");
  EXPECT_EQ(text_of(segments[3], "00620005"), "my knee");
  EXPECT_EQ(term(segments[3], "0062000F"), "SCT 85756007 Tissue");
  for (std::size_t n = 0; n < segments.size(); ++n) {
    EXPECT_EQ(value_of(segments[n], "00620004"), n + 1);
    EXPECT_EQ(text_of(segments[n], "00620008"), "AUTOMATIC");
  }
}

TEST(DicomLabels, KnowACodeForEveryPart) {
  std::set<std::string> codes;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const std::string name(parts[n].name);
    const SegmentTerms terms = terms_of_class(name);
    EXPECT_NE(terms.type.meaning, "Tissue") << name;
    EXPECT_EQ(terms.modifier.meaning, name.ends_with("_left")    ? "Left"
                                      : name.ends_with("_right") ? "Right"
                                                                 : "")
        << name;
    codes.insert(terms.type.value + terms.modifier.value);
  }
  EXPECT_EQ(codes.size(), parts.size() - 1);
  // what is written is read as the same class
  EXPECT_EQ(class_of_terms(terms_of_class("femur_left")), "femur_left");
  EXPECT_EQ(class_of_terms(terms_of_class("kidney_cyst_right")), "kidney_cyst_right");
}

TEST_F(DicomLabelsInDcmtk, ComeFromTheInputAlone) {
  const ScratchFolder folder;
  LabelMap labels = some_labels(grid_of(false, 0));
  const auto first = file_bytes(written(folder, labels, {.version = "1"}));
  EXPECT_EQ(first, file_bytes(written(folder, labels, {.version = "1"}, "again.dcm")));
  const json set = dcmtk_json(folder / "labels.dcm");
  labels.voxels[0] = labels.voxels[0] ? 0 : 1;
  const json other = dcmtk_json(written(folder, labels, {.version = "1"}, "other.dcm"));
  for (const char* tag : {"00080018", "0020000E", "0020000D", "00200052"}) {
    EXPECT_TRUE(text_of(set, tag).starts_with("2.25.")) << tag;
    EXPECT_TRUE(is_dicom_uid(text_of(set, tag)));
    EXPECT_NE(text_of(set, tag), text_of(other, tag)) << tag;
  }
}

// ---- dciodvfy and DCMTK ----

void expect_faultless(const std::string& path) {
  const Said dump = run("dcmdump -q +L " + path);
  EXPECT_EQ(dump.status, 0) << dump.text;
  EXPECT_EQ(dump.text.find("E: "), std::string::npos) << dump.text;
  EXPECT_EQ(dump.text.find("W: "), std::string::npos) << dump.text;
  if (std::system("command -v dciodvfy >/dev/null") != 0) GTEST_SKIP() << "needs dciodvfy of dicom3tools";
  const Said verdict = run("dciodvfy " + path);
  EXPECT_EQ(verdict.status, 0) << verdict.text;
  EXPECT_EQ(verdict.text.find("Error"), std::string::npos) << verdict.text;
  EXPECT_NE(verdict.text.find("Segmentation"), std::string::npos) << verdict.text;  // the class is known
}

TEST_F(DicomLabelsInDcmtk, AreFaultlessWithoutAScan) {
  const ScratchFolder folder;
  expect_faultless(written(folder, some_labels(grid_of(false, 0)), {.version = "0.2.0"}));
}

// ---- labels of a DICOM scan ----

/// A series of six slices in `folder`, along an oblique normal; slice 2 is missing if `with_gap`.
void write_scan(const ScratchFolder& folder, bool with_gap = false) {
  const Grid grid = grid_of(false, 0);
  for (int k = 0; k < 6; ++k) {
    if (with_gap && k == 2) continue;
    TestSlice slice;
    slice.columns = 5, slice.rows = 7;
    slice.instance = fmt::format("1.2.3.7.{}", k + 1), slice.series = "1.2.3.5";
    slice.position = grid.point(0, 0, k);
    slice.along_row = grid.axes.col(0).normalized(), slice.along_column = grid.axes.col(1).normalized();
    slice.row_spacing = 1.3, slice.column_spacing = 0.7;
    slice.pixels.assign(35, static_cast<std::uint16_t>(1000 + k));
    write_slice(folder / fmt::format("{}.dcm", k), slice);
  }
  const Said edit =
      run("dcmodify -nb -i 0020,000d=1.2.3.4 -i 0020,0052=1.2.3.6 -i 0010,0010=Borelli^Giovanni -i "
          "0010,0020=P1679 "
          "-i 0008,0020=20200131 -i 0008,0050=A17 " +
          folder.path() + "/*.dcm");
  ASSERT_EQ(edit.status, 0) << edit.text;
}

TEST_F(DicomLabelsInDcmtk, ReferToTheImagesOfTheScan) {
  const ScratchFolder scan, folder;
  ASSERT_NO_FATAL_FAILURE(write_scan(scan));
  const auto source = read_dicom_source(scan.path());
  ASSERT_TRUE(source) << source.error().message();
  const std::string path =
      written(folder, some_labels(source->grid), {.source = &*source, .version = "0.2.0"});
  expect_faultless(path);
  const json set = dcmtk_json(path);
  EXPECT_EQ(text_of(set, "0020000D"), "1.2.3.4");
  EXPECT_EQ(text_of(set, "00200052"), "1.2.3.6");
  EXPECT_NE(text_of(set, "0020000E"), "1.2.3.5");
  const json series = value_of(set, "00081115");
  EXPECT_EQ(text_of(series, "0020000E"), "1.2.3.5");
  EXPECT_EQ(series.at("0008114A").at("Value").size(), 6U);
  // each frame refers to the image at its position
  for (const json& frame : set.at("52009230").at("Value")) {
    const json position = value_of(frame, "00209113").at("00200032").at("Value");
    const Eigen::Vector3d place(position[0], position[1], position[2]);
    const auto k = std::lround(source->grid.index(place)[2]);
    const json image = value_of(value_of(frame, "00089124"), "00082112");
    EXPECT_EQ(text_of(image, "00081155"), fmt::format("1.2.3.7.{}", k + 1));
    EXPECT_EQ(text_of(image, "00081150"), "1.2.840.10008.5.1.4.1.1.2");
  }
}

TEST_F(DicomLabelsInDcmtk, NameThePatientOnlyIfAsked) {
  const ScratchFolder scan, folder;
  ASSERT_NO_FATAL_FAILURE(write_scan(scan));
  const auto source = read_dicom_source(scan.path());
  ASSERT_TRUE(source) << source.error().message();
  const LabelMap labels = some_labels(source->grid);
  const std::string bare = written(folder, labels, {.source = &*source, .version = "0.2.0"}, "bare.dcm");
  const auto bytes = file_bytes(bare);
  for (const std::string secret : {"Borelli", "P1679", "20200131", "A17"})
    EXPECT_EQ(std::search(bytes.begin(), bytes.end(), secret.begin(), secret.end()), bytes.end()) << secret;
  EXPECT_EQ(text_of(dcmtk_json(bare), "00120062"), "YES");  // identity removed
  const std::string named =
      written(folder, labels, {.source = &*source, .patient = true, .version = "0.2.0"}, "named.dcm");
  expect_faultless(named);
  const json set = dcmtk_json(named);
  EXPECT_EQ(text_of(set, "00100010"), "Borelli^Giovanni");
  EXPECT_EQ(text_of(set, "00100020"), "P1679");
  EXPECT_EQ(text_of(set, "00080020"), "20200131");
  EXPECT_EQ(text_of(set, "00080050"), "A17");
  EXPECT_FALSE(set.contains("00120062"));
}

// The scan's reader interpolates a missing slice from its neighbours, so the frame refers to both.
TEST_F(DicomLabelsInDcmtk, ReferToBothNeighboursOfAFilledSlice) {
  const ScratchFolder scan, folder;
  ASSERT_NO_FATAL_FAILURE(write_scan(scan, true));
  const auto source = read_dicom_source(scan.path());
  ASSERT_TRUE(source) << source.error().message();
  ASSERT_EQ(source->images.size(), 6U);
  ASSERT_EQ(source->images[2].size(), 2U);
  EXPECT_EQ(source->images[2][0].instance_uid, "1.2.3.7.2");
  EXPECT_EQ(source->images[2][1].instance_uid, "1.2.3.7.4");
  EXPECT_EQ(source->images[3].size(), 1U);
}

// ---- refusals ----

std::string refusal(const LabelMap& labels, const DicomLabelOptions& options = {}) {
  const ScratchFolder folder;
  const auto done = write_dicom_labels(folder / "labels.dcm", labels, options);
  EXPECT_FALSE(std::filesystem::exists(folder / "labels.dcm"));
  return done ? "was written" : done.error().message();
}

TEST(DicomLabels, SayWhatDicomCannotHold) {
  const auto says = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  LabelMap labels = some_labels(grid_of(false, 0));
  labels.names[1] = std::string(65, 'x');
  says(refusal(labels), "is longer than DICOM's 64");
  labels.names[1] = "left\\right";
  says(refusal(labels), "cannot hold the name");
  labels.names[1] = "t\xc3\xaate";
  DicomSource source;
  source.grid = labels.grid, source.images.resize(6), source.patient[0x00080005] = "ISO_IR 100";
  says(refusal(labels, {.source = &source, .patient = true}), "character sets");
  source.grid.origin[0] += 1;
  says(refusal(labels, {.source = &source}), "another grid");
  labels.grid.axes.col(1) += 0.001 * labels.grid.axes.col(0);
  says(refusal(labels), "is sheared");
  labels.voxels.assign(labels.voxels.size(), 0);
  says(refusal(labels), "no labelled voxel");
  labels.voxels.pop_back();
  says(refusal(labels), "210 voxels, and the volume has 209");
}

TEST_F(DicomLabelsInDcmtk, HoldNamesInUtf8) {
  const ScratchFolder folder;
  LabelMap labels = some_labels(grid_of(false, 0));
  labels.names[30] = "t\xc3\xaate";
  EXPECT_EQ(text_of(dcmtk_json(written(folder, labels)).at("00620002").at("Value").at(3), "00620005"),
            "t\xc3\xaate");
}

TEST(DicomLabels, NameAFullDisk) {
  const ScratchFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "a.dcm");
  const auto done = write_dicom_labels(folder / "a.dcm", some_labels(grid_of(false, 0)), {});
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message().find("No space left on device"), std::string::npos)
      << done.error().message();
}

}  // namespace
}  // namespace borelli::dicom_labels_test
