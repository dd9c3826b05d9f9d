// Segments that overlap, in each format that allows it.
#include "segmentation/files/segment_overlaps.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/segmentation/scratch_folder.hpp"
#include "tests/segmentation/test_data_set.hpp"

namespace borelli::segment_overlaps_test {
namespace {

constexpr std::size_t length = 200;  // voxels, in one row

struct Run {  // a segment's voxels
  std::string name;
  std::size_t first, last;
};
using Runs = std::vector<Run>;

// As 3D Slicer saves overlapping segments: one layer each.
std::string put_layers(const ScratchFolder& folder, const Runs& segments) {
  std::string header = "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 200 1 1 " +
                       std::to_string(segments.size()) +
                       "\nspace: left-posterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,2) none\n"
                       "kinds: domain domain domain list\nencoding: raw\n";
  std::vector<char> voxels;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const std::string key = "Segment" + std::to_string(n) + "_";
    header += key + "Name:=" + segments[n].name + "\n" + key + "LabelValue:=1\n" + key +
              "Layer:=" + std::to_string(n) + "\n";
    for (std::size_t o = 0; o < length; ++o)
      voxels.push_back(o >= segments[n].first && o < segments[n].last ? 1 : 0);
  }
  header += "\n";
  voxels.insert(voxels.begin(), header.begin(), header.end());
  put_bytes(folder / "a.seg.nrrd", voxels);
  return folder / "a.seg.nrrd";
}

// A binary DICOM-SEG with one frame per segment.
std::string put_dicom(const ScratchFolder& folder, const Runs& segments) {
  std::vector<DataSet> frames, list;
  std::string bits(segments.size() * length / 8, '\0');
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const auto number = static_cast<std::uint16_t>(n + 1);
    DataSet frame;
    frame.sequence(0x00209113, {DataSet().add(0x00200032, "DS", "0\\0\\0")}, false)
        .sequence(0x0062000a, {DataSet().number(0x0062000b, number)}, false);
    frames.push_back(frame);
    list.push_back(DataSet().number(0x00620004, number).add(0x00620005, "LO", segments[n].name));
    for (std::size_t o = segments[n].first; o < segments[n].last; ++o) {
      const std::size_t bit = n * length + o;
      bits[bit / 8] = static_cast<char>(bits[bit / 8] | 1 << bit % 8);
    }
  }
  DataSet shared, file;
  shared.sequence(0x00209116, {DataSet().add(0x00200037, "DS", "1\\0\\0\\0\\1\\0")}, false)
      .sequence(0x00289110, {DataSet().add(0x00180050, "DS", "2").add(0x00280030, "DS", "2\\2")}, false);
  file.add(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
      .add(0x00080018, "UI", "1.2.3.5")
      .add(0x00080060, "CS", "SEG");
  file.add(0x0020000e, "UI", "1.2.9").number(0x00280002, 1).add(0x00280004, "CS", "MONOCHROME2");
  file.add(0x00280008, "IS", std::to_string(frames.size())).number(0x00280010, 1).number(0x00280011, length);
  file.number(0x00280100, 1).number(0x00280101, 1).number(0x00280102, 0).number(0x00280103, 0);
  file.add(0x00620001, "CS", "BINARY").sequence(0x00620002, list, false);
  file.sequence(0x52009229, {shared}, false).sequence(0x52009230, frames, false).add(0x7fe00010, "OB", bits);
  file.write(folder / "a.dcm", "1.2.840.10008.5.1.4.1.1.66.4");
  return folder / "a.dcm";
}

// A folder of masks; their order is that of their names.
std::string put_masks(const ScratchFolder& folder, const Runs& segments) {
  const std::string masks = folder / "masks";
  std::filesystem::remove_all(masks);
  std::filesystem::create_directory(masks);
  for (const Run& run : segments) {
    LabelMap mask{{Grid{}, std::vector<std::uint8_t>(length, 0)}, {"outside", "1"}, {}};
    mask.grid.size = {length, 1, 1};
    mask.grid.axes *= 2;
    std::fill(mask.voxels.begin() + static_cast<std::ptrdiff_t>(run.first),
              mask.voxels.begin() + static_cast<std::ptrdiff_t>(run.last), std::uint8_t{1});
    EXPECT_TRUE(write_labels(masks + "/" + run.name + ".nrrd", mask));
    std::filesystem::remove(masks + "/" + run.name + ".tsv");
  }
  return masks;
}

constexpr std::array writers{put_layers, put_dicom, put_masks};

std::ptrdiff_t voxels_of(const LabelMap& map, const std::string& name) {
  const auto label = std::ranges::find(map.names, name) - map.names.begin();
  return std::ranges::count(map.voxels, label);
}

// The tumour comes later and the box earlier than the thigh, in every format.
TEST(SegmentOverlaps, PartsKeepTheirVoxelsAgainstOtherSegments) {
  for (const auto& write : writers) {
    const ScratchFolder folder;
    const auto read =
        read_labels(write(folder, {{"box", 0, 200}, {"thigh_left", 20, 60}, {"tumour", 40, 60}}));
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(voxels_of(*read, "thigh_left"), 40);
    EXPECT_EQ(read->voxels[30], part_label("thigh_left"));
    EXPECT_EQ(std::ranges::count(read->names, "box"), 1);
    EXPECT_EQ(voxels_of(*read, "box") + voxels_of(*read, "tumour"), 160);
    std::string all;
    for (const auto& warning : read->warnings) all += warning + "\n";
    for (const std::string said :
         {"the segment tumour is neither a part nor a class of a mapping, so the 20 ",
          "the segment box is neither", "shares with thigh_left remain theirs"})
      EXPECT_NE(all.find(said), std::string::npos) << said << "\n" << all;
  }
}

TEST(SegmentOverlaps, ASegmentWithoutVoxelsLeftIsNoLabel) {
  for (const auto& write : writers) {
    const ScratchFolder folder;
    const auto read = read_labels(write(folder, {{"thigh_left", 20, 60}, {"tumour", 40, 60}}));
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(std::ranges::count(read->names, "tumour"), 0);
  }
}

TEST(SegmentOverlaps, RefusesPartsThatOverlapByName) {
  for (const auto& write : writers) {
    const ScratchFolder folder;
    const auto read = read_labels(write(folder, {{"shank_left", 0, 100}, {"thigh_left", 90, 150}}));
    ASSERT_FALSE(read);
    // 10 of the 60 voxels of the smaller one
    EXPECT_NE(read.error().message().find("overlap: shank_left and thigh_left by 17 %"), std::string::npos)
        << read.error().message();
  }
}

TEST(SegmentOverlaps, TellsOfASmallOverlapOfParts) {
  for (const auto& write : writers) {
    const ScratchFolder folder;
    const auto read = read_labels(write(folder, {{"shank_left", 0, 101}, {"thigh_left", 100, 200}}));
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(voxels_of(*read, "shank_left"), 100);
    EXPECT_EQ(voxels_of(*read, "thigh_left"), 100);
    ASSERT_EQ(read->warnings.size(), 1U);
    EXPECT_EQ(read->warnings[0].find("1 voxels are in two segments (shank_left and thigh_left)"), 0U)
        << read->warnings[0];
  }
}

TEST(SegmentOverlaps, ClassesOfTheMappingKeepTheirVoxels) {
  for (const auto& write : writers) {
    const ScratchFolder folder;
    const std::string path = write(folder, {{"femur_left", 20, 60}, {"tumour", 40, 60}});
    const auto read = read_classes(path, "", "totalsegmentator");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(voxels_of(read->labels, "femur_left"), 40);
    ASSERT_FALSE(read->warnings.empty());
    EXPECT_NE(read->warnings[0].find("the segment tumour is neither"), std::string::npos);
  }
}

TEST(SegmentOverlaps, RefusesTwoPartsOfOneName) {
  for (const auto& write : {put_layers, put_dicom}) {
    const ScratchFolder folder;
    const auto read = read_labels(write(folder, {{"foot_left", 0, 100}, {"foot_left", 120, 150}}));
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message().find("has two segments named foot_left"), std::string::npos)
        << read.error().message();
    EXPECT_TRUE(read_labels(write(folder, {{"lesion", 0, 100}, {"lesion", 120, 150}})));
  }
}

}  // namespace
}  // namespace borelli::segment_overlaps_test
