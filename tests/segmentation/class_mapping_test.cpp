// Tables from class to part: their forms, their errors, and the ready ones.
#include "segmentation/files/class_mapping.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "scratch_folder.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

PartSet bits(std::initializer_list<const char*> names) {
  PartSet set = 0;
  for (const char* name : names) set |= part_bit(part_label(name));
  return set;
}

Result<ClassMapping> mapping_of(const std::string& name, const std::string& text) {
  ScratchFolder folder;
  std::ofstream(folder / name, std::ios::binary) << text;
  return class_mapping(folder / name);
}

TEST(ClassMapping, TableAndJsonAgree) {
  const auto table = mapping_of(
      "m.tsv",
      "# mine\nlabel\tname\tpart\ttissue\r\n7\tThigh bone (L)\tthigh_left\tbone\r\n8\tarms\tarm\t\r\n"
      "9\tcouch\toutside\n10\tpsoas\tmiddle_trunk, lower_trunk,thigh\tsoft\n");
  ASSERT_TRUE(table) << table.error().message();
  const auto json =
      mapping_of("m.json", R"({"thigh-bone l": {"part": "thigh_left", "tissue": "bone"}, "8": "arm",
                                             "couch": "outside", "10": "middle_trunk,lower_trunk,thigh"})");
  ASSERT_TRUE(json) << json.error().message();
  for (const auto& m : {*table, *json}) {
    ASSERT_TRUE(m.find(99, "THIGH_BONE_L"));
    EXPECT_EQ(*m.find(99, "thigh.bone.l"), (ClassRule{bits({"thigh_left"}), ClassTissue::bone}));
    EXPECT_EQ(m.find(8, "")->parts, bits({"upper_arm_left", "upper_arm_right", "forearm_left",
                                          "forearm_right", "hand_left", "hand_right"}));
    EXPECT_EQ(m.find(1, "couch")->parts, 0U);
    const PartSet psoas = bits({"middle_trunk", "lower_trunk", "thigh_left", "thigh_right"});
    EXPECT_EQ(m.find(10, "")->parts, psoas);
    EXPECT_EQ(m.find(11, ""), nullptr);
    EXPECT_EQ(m.find(7, "heart"), nullptr);  // another version's numbers
  }
  EXPECT_EQ(table->find(10, "heart"), nullptr);
  EXPECT_NE(json->find(10, "heart"), nullptr);  // a number without a name
}

TEST(ClassMapping, ReportsErrorsWithTheirLine) {
  const auto expect = [](const std::string& name, const std::string& text, const std::string& said) {
    const auto read = mapping_of(name, text);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find(said), std::string::npos) << read.error().message();
  };
  expect("m.tsv", "label\tname\n1\tx\n", "m.tsv:1: expected the header");
  expect("m.tsv", "label\tpart\n1\thead\n2\ttail\n", "m.tsv:3: 'tail' is not a part");
  expect("m.tsv", "label\tpart\n1\thead, outside\n", "m.tsv:2: a class that is outside");
  expect("m.tsv", "label\tpart\n-1\thead\n", "m.tsv:2: expected a label, a whole number from 0; found '-1'");
  expect("m.tsv", "label\tpart\n1\thead\n1\thand\n", "m.tsv:3: label 1 appears twice");
  expect("m.tsv", "name\tpart\tlabel\nA b\thead\t\na_B\thand\t\n", "m.tsv:3: a_b appears twice");
  expect("m.tsv", "label\tpart\n0\thead\n", "m.tsv:2: label 0");
  expect("m.tsv", "label\tpart\ttissue\n1\thead\twood\n", "'wood' is not a tissue");
  expect("m.tsv", "label\tpart\n", "m.tsv: contains no class");
  expect("m.json", "[1]", "is not a mapping");
  expect("m.json", R"({"a": 1})", "m.json: a: expected a part");
  expect("m.json", R"({"1": "thigh_left", "2": "head", "1": "thigh_right"})", "m.json: \"1\" appears twice");
  expect("m.json", R"({"1": {"part": "head", "part": "hand"}})", "m.json: \"part\" appears twice");
  EXPECT_TRUE(mapping_of("m.json", R"({"1": {"part": "head"}, "2": {"part": "head"}})"));
  const auto missing = class_mapping("no_such_mapping");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, Error::Kind::use);
}

// The numbering of TotalSegmentator's task `total`, version 2, sampled over its list.
TEST(ClassMapping, TotalSegmentator) {
  const auto m = class_mapping("totalsegmentator");
  ASSERT_TRUE(m) << m.error().message();
  ASSERT_GE(m->entries.size(), 117U);
  // what follows are names of version 1 and of total_mr, without numbers
  for (std::size_t n = 117; n < m->entries.size(); ++n) EXPECT_FALSE(m->entries[n].label);
  for (std::size_t n = 0; n < 117; ++n) EXPECT_EQ(m->entries[n].label, static_cast<std::int64_t>(n) + 1);
  for (const auto& [number, name] : {std::pair{1, "spleen"},
                                     {25, "sacrum"},
                                     {27, "vertebrae_L5"},
                                     {44, "vertebrae_C7"},
                                     {50, "vertebrae_C1"},
                                     {52, "aorta"},
                                     {69, "humerus_left"},
                                     {75, "femur_left"},
                                     {78, "hip_right"},
                                     {79, "spinal_cord"},
                                     {87, "autochthon_right"},
                                     {91, "skull"},
                                     {92, "rib_left_1"},
                                     {115, "rib_right_12"},
                                     {117, "costal_cartilages"}})
    EXPECT_EQ(m->entries[static_cast<std::size_t>(number - 1)].name, name);
  EXPECT_EQ(*m->find(75, ""), (ClassRule{bits({"thigh_left"}), ClassTissue::bone}));
  // names override numbers: in version 1 the femora were 88 and 89
  EXPECT_EQ(m->find(88, "femur_left")->parts, bits({"thigh_left"}));
  EXPECT_EQ(m->find(89, "")->parts, bits({"middle_trunk", "lower_trunk", "thigh_right"}));
}

// Every organ of the ICRP phantom's table has a rule, and whole bones have one part per side.
TEST(ClassMapping, Icrp110) {
  const auto m = class_mapping("icrp110");
  ASSERT_TRUE(m) << m.error().message();
  EXPECT_EQ(*m->find(28, ""), (ClassRule{bits({"thigh_left", "thigh_right"}), ClassTissue::bone}));
  EXPECT_EQ(m->find(141, "")->parts, 0U);
  std::ifstream organs(test::shared_folder() + "/volumes/icrp_am/AM_organs.csv");
  if (!organs) GTEST_SKIP() << "shared/volumes/icrp_am/AM_organs.csv is not there";
  std::string line;
  std::getline(organs, line);
  int count = 0;
  while (std::getline(organs, line)) {
    const auto comma = line.find(',');
    const std::int64_t id = std::stoll(line.substr(0, comma));
    if (id == 0) continue;
    auto name = line.substr(comma + 1, line.find(',', comma + 1) - comma - 1);
    if (line[comma + 1] == '"') name = line.substr(comma + 2, line.find('"', comma + 2) - comma - 2);
    const ClassRule* rule = m->find(id, "");
    ASSERT_TRUE(rule) << id;
    if (id < 141) {
      EXPECT_EQ(rule, m->find(0, name)) << name;
    }
    ++count;
  }
  EXPECT_EQ(count, 138);  // 1 to 141 without three of the female alone
}

}  // namespace
}  // namespace borelli
