#include "segmentation/labelling/segments.hpp"

#include <gtest/gtest.h>

#include <map>

namespace borelli {
namespace {

std::vector<std::string> part_names() {
  std::vector<std::string> names;
  for (const Part& part : parts) names.emplace_back(part.name);
  return names;
}

TEST(Segments, ReadsPartsAndGroupsByName) {
  const auto choice = choose_segments("trunk, thigh_left");
  ASSERT_TRUE(choice) << choice.error().message();
  ASSERT_EQ(choice->size(), 2u);
  EXPECT_EQ(choice->at(0).of, (std::vector<std::string>{"lower_trunk", "middle_trunk", "upper_trunk"}));
  EXPECT_EQ(choice->at(1).of, std::vector<std::string>{"thigh_left"});
  EXPECT_TRUE(choose_segments("").value().empty());
}

TEST(Segments, EveryGroupFollowsOneChain) {
  for (const SegmentGroup& group : segment_groups)
    for (std::size_t n = 0; n < group.parts.size(); ++n) {
      const int label = part_label(group.parts[n]);
      ASSERT_GT(label, 0) << group.name;
      if (n == 0) continue;
      EXPECT_EQ(parts[static_cast<std::size_t>(label)].parent, group.parts[n - 1]) << group.name;
    }
}

TEST(Segments, RefusesUnknownNamesInOneSentence) {
  const std::map<std::string, std::vector<std::string>> said{
      {"thigh", {"'thigh'", "thigh_left", "arm_right", "trunk"}},
      {"head,,hand_left", {"unknown segment ''"}},
      {"head,head", {"head is named twice"}},
      {"leg_left,foot_left", {"leg_left", "foot_left", "name only one of them"}}};
  for (const auto& [list, words] : said) {
    const auto choice = choose_segments(list);
    ASSERT_FALSE(choice) << list;
    EXPECT_EQ(choice.error().kind, Error::Kind::use) << list;
    for (const auto& word : words)
      EXPECT_NE(choice.error().message().find(word), std::string::npos) << choice.error().message();
    EXPECT_EQ(choice.error().message().find('\n'), std::string::npos);
  }
}

TEST(Segments, ForeignLabelMapsKeepTheirNames) {
  const std::vector<std::string> names{"outside", "liver", "", "trunk"};
  EXPECT_EQ(choose_segments("liver,trunk", names).value().at(1).of, std::vector<std::string>{"trunk"});
  EXPECT_FALSE(choose_segments("thigh_left", names));
  EXPECT_FALSE(choose_segments("arm_left", names));
}

TEST(Segments, LabelsOfChosenSegmentsKeepTheirNumbers) {
  LabelMap all;
  all.grid.size = {17, 1, 1};
  for (std::uint8_t label = 0; label < 17; ++label) all.voxels.push_back(label);
  all.names = part_names();
  const LabelMap asked = labels_of_segments(all, choose_segments("foot_right,trunk").value());
  const std::vector<std::uint8_t> expected{0, 0, 17, 17, 17, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 16};
  EXPECT_EQ(asked.voxels, expected);
  ASSERT_EQ(asked.names.size(), 18u);
  for (std::size_t label = 1; label < 18; ++label)
    EXPECT_EQ(asked.names[label], label == 16 ? "foot_right" : label == 17 ? "trunk" : "") << label;
  EXPECT_TRUE(asked.grid == all.grid);
  EXPECT_EQ(labels_of_segments(all, {}).voxels, all.voxels);
}

TEST(Segments, AttachToTheSegmentOfTheirParent) {
  const auto parents = [](std::vector<std::string> present) {
    std::map<std::string_view, std::pair<std::string_view, std::string_view>> by_name;
    for (const Part& part : segment_tree(present)) by_name[part.name] = {part.parent, part.joint};
    return by_name;
  };
  using Hangs = std::pair<std::string_view, std::string_view>;
  const auto some = parents({"arm_left", "foot_right", "head", "leg_right", "liver", "trunk"});
  EXPECT_EQ(some.size(), 5u);  // the liver is not a part
  EXPECT_EQ(some.at("trunk"), (Hangs{"", ""}));
  EXPECT_EQ(some.at("head"), (Hangs{"trunk", "neck"}));
  EXPECT_EQ(some.at("arm_left"), (Hangs{"trunk", "shoulder_left"}));
  EXPECT_EQ(some.at("leg_right"), (Hangs{"trunk", "hip_right"}));
  EXPECT_EQ(parents({"hand_left"}).at("hand_left"), (Hangs{"forearm_left", "wrist_left"}));
  const auto all = part_names();
  const auto tree = segment_tree(all);
  ASSERT_EQ(tree.size(), parts.size() - 1);
  for (std::size_t label = 1; label < parts.size(); ++label) {
    EXPECT_EQ(tree[label - 1].name, parts[label].name);
    EXPECT_EQ(tree[label - 1].parent, parts[label].parent);
  }
}

}  // namespace
}  // namespace borelli
