// Bodies that lack a limb: parts stated as absent are not searched, and the other side is unaffected.
#include "segmentation/vocabulary/absent_parts.hpp"

#include <gtest/gtest.h>

#include <set>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {
namespace {

TEST(AbsentParts, IncludePartsBeyondThem) {
  const auto absent = parse_absent("thigh_left, hand_right");
  ASSERT_TRUE(absent) << absent.error().message();
  std::set<std::string> names;
  for (std::size_t n = 1; n < parts.size(); ++n)
    if ((*absent)[n]) names.insert(std::string(parts[n].name));
  EXPECT_EQ(names, (std::set<std::string>{"thigh_left", "shank_left", "foot_left", "hand_right"}));
  EXPECT_EQ(in_text(*absent), "hand_right,thigh_left");
  EXPECT_FALSE(any_absent(*parse_absent("")));
  for (const char* wrong : {"head", "leg_left", "thigh", "thigh_left,", "outside", "thigh_left,,foot_left"}) {
    const auto refused = parse_absent(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().kind, Error::Kind::use);
    EXPECT_NE(refused.error().message().find("thigh_left"), std::string::npos);
  }
}

// The phantom with some parts, or a piece of one, replaced by air.
class OneSided : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    body_ = new Phantom(*build_phantom({}));
    GridOptions grid;
    grid.spacing.setConstant(4);
    scan_ = new Scan(voxelise(*body_, phantom_grid(*body_, grid), {.partial_volume = true, .noise_hu = 10}));
    whole_ = new Segmentation(*segment(scan_->grey));
  }
  static void TearDownTestSuite() { delete body_, delete scan_, delete whole_; }

  // `stump`: this part ends at a share of its length from its joint towards the next
  static GreyVolume without(const std::set<std::string>& gone, const std::string& stump = "",
                            const std::string& from = "", const std::string& to = "", double share = 0) {
    GreyVolume scan = scan_->grey;
    const Grid& g = scan.grid;
    Eigen::Vector3d cut = Eigen::Vector3d::Zero(), along = Eigen::Vector3d::Zero();
    if (!stump.empty()) {
      const Eigen::Vector3d a = body_->landmarks.at(from).point, b = body_->landmarks.at(to).point;
      cut = a + share * (b - a), along = b - a;
    }
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const std::string name(parts[scan_->labels.at(i, j, k)].name);
          const bool off = gone.contains(name) || (name == stump && (g.point(i, j, k) - cut).dot(along) > 0);
          if (off) scan.voxels[g.offset(i, j, k)] = -1000;
        }
    return scan;
  }

  // expects all parts as in the whole body, except those that end in `side` and the trunk's, which contain
  // the rest of the limb
  static void expect_as_in_whole(const Segmentation& found, std::string_view side) {
    for (std::size_t n = 1; n < parts.size(); ++n) {
      if (parts[n].name.ends_with(side) || parts[n].name.ends_with("_trunk")) continue;
      EXPECT_EQ(found.part[n].coverage, Coverage::whole) << parts[n].name << ": " << found.part[n].note;
      // the work grid of a smaller body is shifted by a part of its step
      EXPECT_NEAR(found.part[n].volume / whole_->part[n].volume, 1, 0.015) << parts[n].name;
      EXPECT_NEAR(found.part[n].confidence, whole_->part[n].confidence, 0.05) << parts[n].name;
    }
  }

  static const PartFinding& part(const Segmentation& found, std::string_view name) {
    return found.part[static_cast<std::size_t>(part_label(name))];
  }
  static bool says(const Segmentation& found, const std::string& text) {
    for (const Warning& warning : found.warnings)
      if (warning.text.find(text) != std::string::npos) return true;
    return false;
  }
  static Segmentation segmented(const GreyVolume& scan, const char* absent) {
    SegmentOptions options;
    options.absent = *parse_absent(absent);
    const auto found = segment(scan, options);
    EXPECT_TRUE(found);
    return found ? *found : Segmentation{};
  }

  static inline const Phantom* body_ = nullptr;
  static inline const Scan* scan_ = nullptr;
  static inline const Segmentation* whole_ = nullptr;
};

const std::set<std::string> leg{"thigh_left", "shank_left", "foot_left"},
    arm{"upper_arm_left", "forearm_left", "hand_left"};

TEST_F(OneSided, LegThatEndsAboveTheKneeIsAStump) {
  const auto scan = without({"shank_left", "foot_left"}, "thigh_left", "hip_left", "knee_left", 0.6);
  const Segmentation found = segmented(scan, "shank_left");
  expect_as_in_whole(found, "_left");
  const PartFinding& thigh = part(found, "thigh_left");
  EXPECT_EQ(thigh.coverage, Coverage::cut);
  EXPECT_EQ(thigh.note, "stump: shank and foot are stated as absent");
  EXPECT_NEAR(thigh.confidence, part(*whole_, "thigh_left").confidence, 0.05);
  for (const char* name : {"shank_left", "foot_left"}) {
    EXPECT_EQ(part(found, name).coverage, Coverage::absent);
    EXPECT_EQ(part(found, name).note, "stated as absent");
  }
  for (const char* mark : {"knee_left", "ankle_left", "toe_tip_left"})
    EXPECT_FALSE(found.landmarks.contains(mark)) << mark;
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front().text;
  // without the statement the missing limb is doubted, and the other side is unaffected
  const Segmentation doubted = segmented(scan, "");
  expect_as_in_whole(doubted, "_left");
  EXPECT_EQ(part(doubted, "thigh_left").note, "no knee was found: this part includes the shank and foot");
}

TEST_F(OneSided, ForearmThatEndsAboveTheWristIsAStump) {
  const Segmentation found =
      segmented(without({"hand_left"}, "forearm_left", "elbow_left", "wrist_left", 0.5), "hand_left");
  expect_as_in_whole(found, "_left");
  EXPECT_EQ(part(found, "forearm_left").note, "stump: hand is stated as absent");
  EXPECT_EQ(part(found, "upper_arm_left").coverage, Coverage::whole);
  EXPECT_NEAR(part(found, "upper_arm_left").volume / part(*whole_, "upper_arm_left").volume, 1, 0.02);
  EXPECT_FALSE(found.landmarks.contains("wrist_left"));
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front().text;
}

TEST_F(OneSided, OneLegIsFoundWithoutTheOther) {
  const GreyVolume scan = without(leg);
  for (const char* told : {"thigh_left", ""}) {
    const Segmentation found = segmented(scan, told);
    expect_as_in_whole(found, "_left");
    EXPECT_EQ(part(found, "thigh_left").coverage, Coverage::absent) << told;
    EXPECT_EQ(part(found, "hand_left").coverage, Coverage::whole) << told;
    EXPECT_FALSE(found.landmarks.contains("hip_left"));
    const Eigen::Vector3d middle = body_->landmarks.at("mid_hip").point;
    EXPECT_LT((found.landmarks.at("mid_hip").point - middle).norm(), 8) << told;
    EXPECT_EQ(says(found, "give --absent thigh_left"), *told == '\0');
    EXPECT_EQ(part(found, "thigh_left").note, *told ? "stated as absent" : "");
  }
}

TEST_F(OneSided, OneArmIsFoundWithoutTheOther) {
  const GreyVolume scan = without(arm);
  for (const char* told : {"upper_arm_left", ""}) {
    const Segmentation found = segmented(scan, told);
    expect_as_in_whole(found, "_left");
    EXPECT_EQ(part(found, "upper_arm_left").coverage, Coverage::absent) << told;
    EXPECT_EQ(part(found, "foot_left").coverage, Coverage::whole) << told;
    EXPECT_EQ(says(found, "give --absent upper_arm_left"), *told == '\0');
  }
}

TEST_F(OneSided, RefusesLandmarksOfAbsentParts) {
  SegmentOptions options;
  options.absent = *parse_absent("shank_left");
  options.given["knee_left"] = body_->landmarks.at("knee_left");
  const auto refused = segment(scan_->grey, options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, Error::Kind::use);
}

}  // namespace
}  // namespace borelli
