// Tables from joint names to segments.
#include "pipeline/recordings/joint_mapping.hpp"

#include <gtest/gtest.h>

namespace borelli::test::joint_mapping_test {
namespace {

TEST(JointMapping, TabsEqualSignsAndBlanksSeparateTheNames) {
  const auto mapping = parse_joint_mapping(
      "# of a program\njoint\tsegment\nmixamorig:Hips\tlower_trunk\r\nLeft Up Leg = thigh_left\n\n"
      "Right Up Leg   thigh_right\nSpine 1\tmiddle_trunk\n",
      "a.txt");
  ASSERT_TRUE(mapping) << mapping.error().message();
  ASSERT_EQ(mapping->entries.size(), 4U);
  EXPECT_EQ(*mapping->find("mixamorig:Hips"), "lower_trunk");
  EXPECT_EQ(*mapping->find("Left Up Leg"), "thigh_left");
  EXPECT_EQ(*mapping->find("Right Up Leg"), "thigh_right");
  EXPECT_EQ(*mapping->find("Spine 1"), "middle_trunk");
  EXPECT_EQ(mapping->entries[1].line, 4);
  EXPECT_EQ(mapping->find("hips"), nullptr);
}

TEST(JointMapping, MistakesAreNamedWithTheirLine) {
  const auto error = [](const std::string& text) {
    const auto mapping = parse_joint_mapping(text, "a.txt", {"thigh_left", "thigh_right"});
    return mapping ? "no error" : mapping.error().message();
  };
  EXPECT_EQ(error("Hips\n"),
            "a.txt:1: is 'Hips', expected a name and its place, as in 'LeftUpLeg = thigh_left'");
  EXPECT_EQ(error("Hips =\n"),
            "a.txt:1: is 'Hips =', expected a name and its place, as in 'LeftUpLeg = thigh_left'");
  EXPECT_EQ(error("a thigh_lift\n"),
            "a.txt:1: 'thigh_lift' is not a place on the body, did you mean 'thigh_left'?");
  EXPECT_EQ(error("a thigh_left\na thigh_right\n"), "a.txt:2: lists the joint 'a' twice; remove one");
  EXPECT_EQ(error("# nothing\n"), "a.txt: contains no line; expected lines like 'LeftUpLeg = thigh_left'");
  EXPECT_EQ(read_joint_mapping("/dev/zero").error().message(),
            "/dev/zero: is not a regular file but a pipe or a device");
}

TEST(JointMapping, EachJointIsOneOfTheMotion) {
  const auto mapping = parse_joint_mapping("LeftLeg thigh_left\nLeftArm forearm_left\n", "a.txt");
  ASSERT_TRUE(mapping);
  EXPECT_TRUE(check_joints(*mapping, {"LeftArm", "LeftLeg", "Hips"}, "a.txt"));
  EXPECT_EQ(check_joints(*mapping, {"LeftArms", "LeftLeg"}, "a.txt").error().message(),
            "a.txt:2: lists 'LeftArm', which is not in the motion, did you mean 'LeftArms'?");
}

}  // namespace
}  // namespace borelli::test::joint_mapping_test
