// BVH files: a real one, hand-written files in unusual layouts, and refusals.
#include "pipeline/recordings/bvh_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/paths.hpp"

namespace borelli::test::bvh_file_test {
namespace {

const std::string bvh_arm =
    "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0 1 0\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
    "Yrotation\n"
    "\tJOINT Left Arm\n\t{\n\t\tOFFSET 2 0 0\n\t\tCHANNELS 1 Zrotation\n\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 3 "
    "0 0\n"
    "\t\t}\n\t}\n}\nMOTION\nFrames: 2\nFrame Time: 0.5\n1 2 3 0 0 0 90\n1 2 3 0 0 0 -90\n";

std::string bvh_error(const std::string& text) {
  const auto motion = parse_bvh(text, "a.bvh");
  return motion ? "no error" : motion.error().message();
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  return at == text.npos ? "no '" + from + "' to replace" : text.replace(at, from.size(), to);
}

void expect_same_bvh(const BvhMotion& a, const BvhMotion& b) {
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    EXPECT_EQ(a.joints[i].name, b.joints[i].name);
    EXPECT_EQ(a.joints[i].parent, b.joints[i].parent);
    EXPECT_EQ(a.joints[i].end_site, b.joints[i].end_site);
    EXPECT_EQ(a.joints[i].offset, b.joints[i].offset);
    ASSERT_EQ(a.joints[i].channels.size(), b.joints[i].channels.size());
    for (std::size_t c = 0; c < a.joints[i].channels.size(); ++c) {
      EXPECT_EQ(a.joints[i].channels[c].axis, b.joints[i].channels[c].axis);
      EXPECT_EQ(a.joints[i].channels[c].rotation, b.joints[i].channels[c].rotation);
    }
  }
  EXPECT_EQ(a.frame_time, b.frame_time);
  EXPECT_EQ(a.values, b.values);
}

TEST(BvhFile, WalkMatchesAnotherReader) {
  const std::string file = test::shared_folder() + "/motion/walk1.bvh";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const auto motion = read_bvh(file);
  ASSERT_TRUE(motion) << motion.error().message();
  EXPECT_TRUE(motion->warnings.empty());
  EXPECT_EQ(motion->joints.size(), 91U);
  EXPECT_EQ(motion->values.rows(), 14);
  EXPECT_EQ(motion->values.cols(), 228);
  EXPECT_EQ(motion->frame_time, 0.041667);
  EXPECT_EQ(motion->joints[9].name, "__Tongue1_end");
  EXPECT_EQ(motion->joints[9].offset, Eigen::Vector3d(0, 0.71277, 0.3366));
  EXPECT_EQ(motion->values(1, 4), -5.144296);
  const auto text = bvh_text(*motion, file);
  ASSERT_TRUE(text) << text.error().message();
  const auto again = parse_bvh(*text, file);
  ASSERT_TRUE(again) << again.error().message();
  expect_same_bvh(*motion, *again);
  EXPECT_EQ(bvh_text(*again, file).value(), *text);
}

TEST(BvhFile, ReadsTheHierarchy) {
  const auto motion = parse_bvh(bvh_arm, "a.bvh");
  ASSERT_TRUE(motion) << motion.error().message();
  ASSERT_EQ(motion->joints.size(), 3U);
  EXPECT_EQ(motion->joints[1].name, "Left Arm");  // a name may hold blanks
  EXPECT_EQ(motion->joints[1].parent, 0);
  EXPECT_EQ(motion->joints[2].name, "Left Arm_end");
  EXPECT_TRUE(motion->joints[2].end_site);
  EXPECT_EQ(motion->joints[0].channels[3].axis, 2);
  EXPECT_TRUE(motion->joints[0].channels[3].rotation);
  EXPECT_EQ(motion->first_channels(), (std::vector<Eigen::Index>{0, 6, 7, 7}));
  EXPECT_EQ(bvh_text(*motion, "a.bvh").value(), bvh_arm);
}

TEST(BvhFile, LayoutsOfOtherProgramsAreRead) {
  const auto plain = parse_bvh(bvh_arm, "a.bvh");
  ASSERT_TRUE(plain);
  std::string windows, blanks, lower;
  for (const char c : bvh_arm) {
    windows += c == '\n' ? "\r\n" : std::string(1, c);
    blanks += c == '\t' ? "   " : c == ' ' ? " \t" : std::string(1, c);
  }
  lower = with(with(with(bvh_arm, "Xposition", "xposition"), "HIERARCHY", "hierarchy"), "JOINT", "Joint");
  blanks = with(blanks, "Left \tArm", "Left Arm");
  for (const std::string& text : {windows, blanks, lower, with(bvh_arm, "ROOT Hips\n{", "ROOT Hips {"),
                                  with(bvh_arm, "Frames: 2\nFrame Time: 0.5", "Frames:2\nFrame Time:\t0.5"),
                                  with(bvh_arm, "Frames: 2\nFrame Time: 0.5", "Frames 2\nFrame Time 0.5"),
                                  with(bvh_arm, "MOTION\n", "MOTION\n\n"), bvh_arm + "\n\n"}) {
    const auto motion = parse_bvh(text, "a.bvh");
    ASSERT_TRUE(motion) << motion.error().message() << "\n" << text;
    EXPECT_TRUE(motion->warnings.empty()) << text;
    expect_same_bvh(*plain, *motion);
  }
}

TEST(BvhFile, SeveralRootsAndJointsWithoutChannelsAreRead) {
  const auto motion = parse_bvh(
      "HIERARCHY ROOT a { OFFSET 0 0 0 CHANNELS 0 JOINT c { CHANNELS 3 Zrotation Zposition Zrotation OFFSET "
      "1 2 3 } }\n"
      "ROOT b { OFFSET 4 5 6 }\nMOTION\nFrames: 1\nFrame Time: 1\n1 2 3\n",
      "a.bvh");
  ASSERT_TRUE(motion) << motion.error().message();
  ASSERT_EQ(motion->joints.size(), 3U);
  EXPECT_EQ(motion->joints[1].parent, 0);
  EXPECT_EQ(motion->joints[2].parent, -1);
  EXPECT_EQ(motion->joints[1].channels.size(), 3U);
  EXPECT_EQ(motion->joints[2].offset, Eigen::Vector3d(4, 5, 6));
}

TEST(BvhFile, WarnsOfMissingRows) {
  const auto fewer = parse_bvh(with(bvh_arm, "Frames: 2", "Frames: 200"), "a.bvh");
  ASSERT_TRUE(fewer);
  EXPECT_EQ(fewer->values.rows(), 2);
  EXPECT_EQ(fewer->warnings, std::vector<std::string>{
                                 "MOTION announces 200 frames, but the file contains 2; those were read."});
  const auto none = parse_bvh(bvh_arm.substr(0, bvh_arm.find("1 2 3 0")), "a.bvh");
  ASSERT_TRUE(none);
  EXPECT_EQ(none->values.rows(), 0);
  EXPECT_EQ(none->warnings.size(), 1U);
  const auto skeleton = parse_bvh(bvh_arm.substr(0, bvh_arm.find("MOTION")), "a.bvh");
  ASSERT_TRUE(skeleton) << skeleton.error().message();
  EXPECT_EQ(skeleton->warnings, std::vector<std::string>{"The file contains a skeleton but no MOTION."});
  EXPECT_EQ(bvh_text(*skeleton, "a.bvh").value(), bvh_arm.substr(0, bvh_arm.find("MOTION")));
}

TEST(BvhFile, BadFilesAreRefusedWithTheirLine) {
  EXPECT_EQ(bvh_error(""), "a.bvh:0: ends here, expected HIERARCHY, the beginning of a BVH file");
  EXPECT_EQ(bvh_error("HIERARCHY\n"), "a.bvh:1: ends here, expected ROOT");
  EXPECT_EQ(bvh_error(with(bvh_arm, "OFFSET 2 0 0", "OFFSET 2 0")),
            "a.bvh:9: has 'CHANNELS', expected the three numbers of an OFFSET");
  EXPECT_EQ(bvh_error(with(bvh_arm, "\t\tOFFSET 2 0 0\n", "")),
            "a.bvh:13: ends the joint 'Left Arm' before its OFFSET");
  EXPECT_EQ(bvh_error(with(bvh_arm, "CHANNELS 1", "CHANNELS 2")),
            "a.bvh:10: has 'End', expected 2 channels, each X, Y or Z with 'position' or 'rotation'");
  EXPECT_EQ(bvh_error(with(bvh_arm, "CHANNELS 1", "CHANNELS 0")),
            "a.bvh:9: has 'Zrotation', expected OFFSET, CHANNELS, JOINT, End Site or a closing brace");
  EXPECT_EQ(bvh_error(with(bvh_arm, "Yposition", "Xposition")),
            "a.bvh:5: gives the joint 'Hips' the channel 'Xposition' twice");
  EXPECT_EQ(bvh_error(with(bvh_arm, "Left Arm", "Hips")),
            "a.bvh:6: lists the joint 'Hips' twice; remove one");
  EXPECT_EQ(bvh_error(with(bvh_arm, "Left Arm", "")), "a.bvh:6: has a joint without a name, expected one");
  EXPECT_EQ(bvh_error(with(bvh_arm, "\t}\n}\n", "\t}\n")),
            "a.bvh:15: has 'MOTION', expected OFFSET, CHANNELS, JOINT, End Site or a closing brace");
  EXPECT_EQ(bvh_error(with(bvh_arm, "0 0 0 90", "0 0 90")),
            "a.bvh:19: has 6 numbers, expected 7: one per channel of the hierarchy");
  EXPECT_EQ(bvh_error(with(bvh_arm, "0 0 0 90", "0 0 0 nan")),
            "a.bvh:19: has 'nan', expected a number with a decimal point");
  EXPECT_EQ(bvh_error(with(bvh_arm, "Time: 0.5", "Time: 0")),
            "a.bvh:18: has the frame time 0 s, expected a positive number");
  EXPECT_EQ(bvh_error(with(bvh_arm, "Frames: 2", "Frames: many")),
            "a.bvh:17: has 'many', expected Frames: and their number");
}

TEST(BvhFile, AChainOfJointsAsDeepAsTheLimitIsReadAndWritten) {
  std::string text = "HIERARCHY\n";
  const int depth = 20000;
  for (int i = 0; i < depth; ++i)
    text += (i == 0 ? "ROOT j" : "JOINT j") + std::to_string(i) + "\n{\nOFFSET 0 1 0\nCHANNELS 0\n";
  text += std::string(depth, '}');
  const auto motion = parse_bvh(text, "a.bvh");
  ASSERT_TRUE(motion) << motion.error().message();
  const auto written = bvh_text(*motion, "a.bvh");
  ASSERT_TRUE(written);
  const auto again = parse_bvh(*written, "a.bvh");
  ASSERT_TRUE(again);
  expect_same_bvh(*motion, *again);
  EXPECT_NE(bvh_error(with(text, "ROOT", "ROOT x{OFFSET 0 0 0} ROOT")).find("more than 20000 joints"),
            std::string::npos);
}

TEST(BvhFile, RefusesToWriteAnInconsistentMotion) {
  BvhMotion motion = parse_bvh(bvh_arm, "a.bvh").value();
  BvhMotion bad = motion;
  bad.joints[1].parent = 1;
  EXPECT_FALSE(bvh_text(bad, "out.bvh"));
  bad = motion, bad.joints[1].name = "a}b";
  EXPECT_FALSE(bvh_text(bad, "out.bvh"));
  bad = motion, bad.values(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(bvh_text(bad, "out.bvh"));
  bad = motion, bad.joints[1].channels.clear();
  EXPECT_FALSE(bvh_text(bad, "out.bvh"));
  bad = motion, bad.frame_time = 0;
  EXPECT_FALSE(bvh_text(bad, "out.bvh"));
}

}  // namespace
}  // namespace borelli::test::bvh_file_test
