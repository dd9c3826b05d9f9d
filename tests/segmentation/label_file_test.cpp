// Reading and writing label maps: numbers, names, parts.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

void put_text(const std::string& path, const std::string& text) {
  put_bytes(path, {text.begin(), text.end()});
}

// labels as int16, as another program may write them
void write_numbers(const std::string& path, const std::vector<std::int16_t>& numbers) {
  GreyVolume volume;
  volume.grid.size = {static_cast<std::int64_t>(numbers.size()), 1, 1};
  volume.quantity = Quantity::labels;
  volume.voxels = numbers;
  ASSERT_TRUE(write_volume(path, volume));
}

TEST(LabelFile, RoundTripsWithItsNames) {
  ScratchFolder folder;
  LabelMap map;
  map.grid = oblique_grid(false, 0.5);
  map.voxels.resize(map.grid.count());
  for (std::size_t n = 0; n < map.voxels.size(); ++n)
    map.voxels[n] = static_cast<std::uint8_t>(n % parts.size());
  for (const Part& part : parts) map.names.emplace_back(part.name);
  for (const std::string name : {"a.nii.gz", "a.nrrd"}) {
    ASSERT_TRUE(write_labels(folder / name, map));
    const auto back = read_labels(folder / name);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->voxels, map.voxels);
    EXPECT_EQ(back->names, map.names);
    EXPECT_LT((back->grid.axes - map.grid.axes).cwiseAbs().maxCoeff(), 1e-6);  // float32 in NIfTI
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "a.tsv"));
}

TEST(LabelFile, NamesAreNeverFormulasAndRoundTrip) {
  ScratchFolder folder;
  LabelMap map;
  map.grid.size = {3, 1, 1};
  map.voxels = {1, 2, 3};
  map.names = {"outside", "=1+1", "@liver", "'-spleen"};
  ASSERT_TRUE(write_labels(folder / "a.nrrd", map));
  std::ifstream table(folder / "a.tsv");
  const std::string text{std::istreambuf_iterator<char>(table), {}};
  EXPECT_EQ(text, "label\tname\n0\toutside\n1\t'=1+1\n2\t'@liver\n3\t''-spleen\n");
  const auto back = read_numbered_labels(folder / "a.nrrd");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->map.names, map.names);
}

// As 3D Slicer saves a segmentation: three segments, two of them overlapping, in two layers, cropped to their
// contents.
TEST(LabelFile, ReadsLayersOf3dSlicer) {
  const std::string keys =
      "Segmentation_ContainedRepresentationNames:=Binary "
      "labelmap|\nSegmentation_MasterRepresentation:=Binary labelmap\n"
      "Segment0_ID:=Segment_1\nSegment0_Name:=femur left\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
      "Segment1_ID:=Segment_2\nSegment1_Name:=skin\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n"
      "Segment2_ID:=Segment_3\nSegment2_Name:=liver\nSegment2_LabelValue:=2\nSegment2_Layer:=0\n";
  const std::string place = "space: left-posterior-superior\nspace origin: (10,20,30)\nencoding: raw\n";
  // voxels of layer 0 and of layer 1
  const std::vector<unsigned char> zero{1, 1, 2, 0}, one{0, 1, 1, 1};
  const std::vector<std::uint8_t> expected{1, 2, 3, 2};  // the later of overlapping segments
  struct Case {
    std::string header;
    std::vector<unsigned char> voxels;
  };
  for (const Case& c : {Case{"NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 2 2 1\nspace directions: "
                             "none (2,0,0) (0,2,0) (0,0,3)\n"
                             "kinds: list domain domain domain\n",
                             {zero[0], one[0], zero[1], one[1], zero[2], one[2], zero[3], one[3]}},
                        {"NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 2 1 2\nspace directions: "
                         "(2,0,0) (0,2,0) (0,0,3) none\n"
                         "kinds: domain domain domain list\n",
                         {zero[0], zero[1], zero[2], zero[3], one[0], one[1], one[2], one[3]}}}) {
    ScratchFolder folder;
    std::string text = c.header + place + keys + "\n";
    const auto put = [&](const char* name, const std::string& before_voxels) {
      std::vector<char> bytes(before_voxels.begin(), before_voxels.end());
      bytes.insert(bytes.end(), c.voxels.begin(), c.voxels.end());
      put_bytes(folder / name, bytes);
    };
    put("a.seg.nrrd", text);
    const auto read = read_numbered_labels(folder / "a.seg.nrrd");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->map.voxels, expected);
    EXPECT_EQ(read->map.names, (std::vector<std::string>{"outside", "femur left", "skin", "liver"}));
    EXPECT_EQ(read->map.grid.size, (std::array<std::int64_t, 3>{2, 2, 1}));
    EXPECT_EQ(read->map.grid.origin, Eigen::Vector3d(10, 20, 30));
    EXPECT_EQ(read->map.grid.spacing(), Eigen::Vector3d(2, 2, 3));
    const auto volume = read_volume(folder / "a.seg.nrrd");
    ASSERT_FALSE(volume);
    EXPECT_NE(volume.error().message().find("segmentation with 2 layers"), std::string::npos);

    // voxels at the file's end, after arbitrary bytes
    std::string skipping = text;
    skipping.insert(skipping.find("encoding"), "byte skip: -1\n");
    put("c.seg.nrrd", skipping + "xyz");
    const auto at_end = read_numbered_labels(folder / "c.seg.nrrd");
    ASSERT_TRUE(at_end) << at_end.error().message();
    EXPECT_EQ(at_end->map.voxels, expected);

    // more voxels than can be counted
    std::string many = text;
    const std::size_t sizes = many.find("sizes: ");
    many.replace(sizes, many.find('\n', sizes) - sizes, "sizes: 65536 65536 65536 65536");
    put("d.seg.nrrd", many);
    const auto damaged = read_labels(folder / "d.seg.nrrd");
    ASSERT_FALSE(damaged);
    EXPECT_NE(damaged.error().message().find("damaged header: it states 1.84e+19 voxels"), std::string::npos)
        << damaged.error().message();

    // keys that name no segment do not make an axis a list of layers
    std::string unnamed = text;
    for (std::size_t at; (at = unnamed.find("\nSegment0_")) != unnamed.npos;)
      unnamed.replace(at + 1, 8, "Another_");
    unnamed.insert(unnamed.find("Another__ID"), "Segment0_LabelValue:=\n");
    put("e.seg.nrrd", unnamed);
    const auto layers = read_labels(folder / "e.seg.nrrd");
    ASSERT_FALSE(layers);
    EXPECT_NE(layers.error().message().find("'space directions' has no vector"), std::string::npos)
        << layers.error().message();

    // a missing layer
    text.replace(text.find("Segment1_Layer:=1"), 17, "Segment1_Layer:=4");
    put("b.seg.nrrd", text);
    const auto bad = read_labels(folder / "b.seg.nrrd");
    ASSERT_FALSE(bad);
    EXPECT_NE(bad.error().message().find("segment 1 ('skin') is value 1 of layer 4"), std::string::npos)
        << bad.error().message();

    // a number beyond 64 bits
    text.replace(text.find("Segment1_Layer:=4"), 17, "Segment1_Layer:=1e19");
    put("c.seg.nrrd", text);
    const auto huge = read_labels(folder / "c.seg.nrrd");
    ASSERT_FALSE(huge);
    EXPECT_NE(huge.error().message().find("is value 1 of layer 1000000000000000,"), std::string::npos)
        << huge.error().message();
  }
}

// One layer: the numbers are the file's own, and parts among the names get their labels.
TEST(LabelFile, ReadsSegmentNamesOf3dSlicer) {
  ScratchFolder folder;
  const std::string text =
      "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 2 2 1\nspace: right-anterior-superior\n"
      "space directions: (2,0,0) (0,2,0) (0,0,3)\nspace origin: (0,0,0)\nencoding: raw\n"
      "Segment0_Name:=thigh_left\nSegment0_LabelValue:=7\nSegment1_Name:=tumour\nSegment1_LabelValue:=3\n\n";
  std::vector<char> bytes(text.begin(), text.end());
  for (const char v : {0, 7, 3, 7}) bytes.push_back(v);
  put_bytes(folder / "a.seg.nrrd", bytes);
  const auto read = read_labels(folder / "a.seg.nrrd");
  ASSERT_TRUE(read) << read.error().message();
  const auto thigh = static_cast<std::uint8_t>(part_label("thigh_left"));
  EXPECT_EQ(read->voxels, (std::vector<std::uint8_t>{0, thigh, 17, thigh}));
  EXPECT_EQ(read->names[17], "tumour");
}

// 3D Slicer's tags give the class if the user renamed the segment, and the segment's ID gives it without
// codes. Codes: DICOM PS3.16, CID 4031 (71341001 femur, T-12710 in SRT), CID 244 (7771000 left, 24028007
// right).
TEST(LabelFile, TerminologyOf3dSlicerGivesTheClass) {
  ScratchFolder folder;
  const auto tags = [](const std::string& type, const std::string& side) {
    return "Segmentation.Status:inprogress|TerminologyEntry:Segmentation category and type - 3D Slicer "
           "General "
           "Anatomy list~SCT^123037004^Anatomical Structure~" +
           type + "~" + side + "~Anatomic codes - DICOM master list~^^~^^|";
  };
  const std::string text =
      "NRRD0005\ntype: unsigned char\ndimension: 4\nsizes: 2 3 2 1\nspace: left-posterior-superior\n"
      "space directions: none (2,0,0) (0,2,0) (0,0,3)\nkinds: list domain domain domain\n"
      "space origin: (0,0,0)\nencoding: raw\n"
      "Segment0_ID:=Segment_1\nSegment0_Name:=Oberschenkelknochen\nSegment0_LabelValue:=1\n"
      "Segment0_Layer:=0\nSegment0_Tags:=" +
      tags("SCT^71341001^Femur", "SCT^7771000^Left") +
      "\nSegment1_ID:=Segment_2\nSegment1_Name:=II\nSegment1_LabelValue:=2\nSegment1_Layer:=0\n"
      "Segment1_Tags:=" +
      tags("SRT^T-12710^Femur", "SRT^G-A100^Right") +
      "\nSegment2_ID:=liver\nSegment2_Name:=L\nSegment2_LabelValue:=1\nSegment2_Layer:=1\nSegment2_Tags:=" +
      tags("SCT^85756007^Tissue", "^^") +
      "\nSegment3_ID:=s4\nSegment3_Name:=Left kidney\nSegment3_LabelValue:=2\nSegment3_Layer:=1\n"
      "Segment3_Tags:=" +
      tags("SCT^64033007^Kidney", "SCT^24028007^Right") + "\n\n";
  std::vector<char> bytes(text.begin(), text.end());
  for (const char v : {0, 0, 1, 0, 2, 0, 0, 1, 0, 2, 0, 1})
    bytes.push_back(v);  // a voxel's layers side by side
  put_bytes(folder / "a.seg.nrrd", bytes);
  const auto classes = read_classes(folder / "a.seg.nrrd", "", "totalsegmentator");
  ASSERT_TRUE(classes) << classes.error().message();
  const auto mapping = class_mapping("totalsegmentator");
  const char* const expected[] = {"", "femur_left", "femur_right", "liver", "kidney_left", "liver"};
  for (std::size_t o = 1; o < 6; ++o)
    EXPECT_EQ(classes->rule(classes->labels.voxels[o]), *mapping->find(-1, expected[o])) << expected[o];
  EXPECT_EQ(classes->labels.voxels[0], 0);
  std::string told;
  for (const std::string& warning : classes->warnings) told += warning + "\n";
  EXPECT_NE(told.find("Oberschenkelknochen is femur_left, II is femur_right, L is liver"), std::string::npos)
      << told;
}

TEST(LabelFile, PartNamesGetTheirLabelsAndOthersFollow) {
  ScratchFolder folder;
  write_numbers(folder / "a.nii", {0, 5, 900, 3, 900, 12});
  put_text(folder / "names.txt",
           "label\tname\tnote\r\n5\tthigh_left\tx\r\n900\thead\ty\r\n3\tliver\tz\r\n0\tair\t\r\n");
  const auto map = read_labels(folder / "a.nii", folder / "names.txt");
  ASSERT_TRUE(map) << map.error().message();
  const auto thigh = static_cast<std::uint8_t>(part_label("thigh_left")),
             head = static_cast<std::uint8_t>(part_label("head"));
  EXPECT_EQ(map->voxels, (std::vector<std::uint8_t>{0, thigh, head, 17, head, 18}));
  EXPECT_EQ(map->names[thigh], "thigh_left");
  EXPECT_EQ(map->names[17], "liver");
  EXPECT_EQ(map->names[18], "label 12");
  EXPECT_EQ(map->names[0], "outside");
}

TEST(LabelFile, TellsOfNumbersThatTheNamesLack) {
  ScratchFolder folder;
  write_numbers(folder / "a.nii", {0, 5, 900, 3, 900, 12});
  put_text(folder / "names.txt", "label\tname\n5\tthigh_left\n3\tliver\n7\tabsent\n");
  const auto map = read_labels(folder / "a.nii", folder / "names.txt");
  ASSERT_TRUE(map) << map.error().message();
  EXPECT_EQ(map->warnings,
            (std::vector<std::string>{"its names lack numbers that its voxels have: 12 (1 voxels), "
                                      "900 (2 voxels)"}));
  EXPECT_TRUE(read_labels(folder / "a.nii")->warnings.empty());  // it has no names at all
  // many: eight, and a count
  std::vector<std::int16_t> many;
  for (std::int16_t n = 0; n < 30; ++n) many.push_back(n);
  write_numbers(folder / "b.nii", many);
  put_text(folder / "b.tsv", "label\tname\n1\thead\n");
  const auto cut_short = read_labels(folder / "b.nii");
  ASSERT_TRUE(cut_short) << cut_short.error().message();
  ASSERT_EQ(cut_short->warnings.size(), 1U);
  EXPECT_TRUE(cut_short->warnings[0].ends_with("9 (1 voxels) and 20 more")) << cut_short->warnings[0];
}

TEST(LabelFile, KeepsNumbersUnlessTheyExceed255) {
  ScratchFolder folder;
  write_numbers(folder / "small.nii", {0, 7, 200});
  EXPECT_EQ(read_labels(folder / "small.nii")->voxels, (std::vector<std::uint8_t>{0, 7, 200}));
  write_numbers(folder / "large.nii", {2035, 0, 1001});
  const auto large = read_labels(folder / "large.nii");
  EXPECT_EQ(large->voxels, (std::vector<std::uint8_t>{2, 0, 1}));
  EXPECT_EQ(large->names, (std::vector<std::string>{"outside", "label 1001", "label 2035"}));
}

TEST(LabelFile, RefusesFilesThatAreNoLabelMap) {
  ScratchFolder folder;
  std::vector<std::int16_t> many(300);
  for (std::size_t n = 0; n < many.size(); ++n) many[n] = static_cast<std::int16_t>(n);
  write_numbers(folder / "many.nii", many);
  write_numbers(folder / "negative.nii", {0, -1, 2});
  write_numbers(folder / "fine.nii", {0, 1, 2});
  const auto refusal = [&](const std::string& name, const std::string& table = "") {
    const auto map = read_labels(folder / name, table.empty() ? "" : folder / table);
    return map ? std::string("was read") : map.error().message();
  };
  EXPECT_NE(refusal("many.nii").find("at most 255"), std::string::npos) << refusal("many.nii");
  EXPECT_NE(refusal("negative.nii").find("-1"), std::string::npos) << refusal("negative.nii");
  EXPECT_NE(refusal("absent.nii").find("no such file"), std::string::npos);
  const std::vector<std::pair<std::string, std::string>> tables{
      {"", "header"},
      {"number\tname\n", "header"},
      {"label\tname\n1 liver\n", ".tsv:2: no tab"},
      {"label\tname\n1\tliver\nx\tspleen\n", ".tsv:3: expected a label, a whole number"},
      {"label\tname\n1\tliver\n1\tspleen\n", "label 1 appears twice"},
      {"label\tname\n1\tliver\n2\tliver\n", "'liver' appears twice"},
      {"label\tname\n1\t\n", "no name"},
  };
  for (const auto& [text, sentence] : tables) {
    put_text(folder / "t.tsv", text);
    EXPECT_NE(refusal("fine.nii", "t.tsv").find(sentence), std::string::npos) << refusal("fine.nii", "t.tsv");
  }
  EXPECT_NE(refusal("fine.nii", "no.tsv").find("no.tsv"), std::string::npos);
}

// Voxels of each id, as counted in the organ list.
TEST(LabelFile, IcrpLabelCountsMatchTheirOrganList) {
  const std::string folder = test::shared_folder() + "/volumes/icrp_am/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the ICRP male is not there: " << folder;
  const auto map = read_labels(folder + "AM_labels.nii.gz");
  ASSERT_TRUE(map) << map.error().message();
  std::array<std::size_t, 256> counted{};
  for (const auto label : map->voxels) ++counted[label];
  std::ifstream list(folder + "AM_organs.csv");
  std::string line;
  std::getline(list, line);
  std::size_t listed = 0;
  while (std::getline(list, line)) {
    // id,name,medium,density,voxels,mass; a name may hold commas in quotes, so the end is counted from the
    // right
    const auto mass = line.rfind(','), voxels = line.rfind(',', mass - 1);
    const auto id = std::stoul(line);
    EXPECT_EQ(counted.at(id), std::stoul(line.substr(voxels + 1))) << line;
    listed += counted[id];
  }
  EXPECT_EQ(listed, map->voxels.size()) << "labels that the list does not have";
}

}  // namespace
}  // namespace borelli
