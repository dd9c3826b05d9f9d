// Scans of a piece of a body: parts in view are found, others are never invented.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "samples/phantom_voxels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/paths.hpp"
#include "tests/segmentation/dice.hpp"
#include "tests/segmentation/slices_between.hpp"

namespace borelli::partial_scan_test {
namespace {

using Eigen::Vector3d;

Segmentation found_in(const GreyVolume& volume, double step = 3) {
  SegmentOptions options;
  options.step = step;
  auto found = segment(volume, options);
  EXPECT_TRUE(found) << found.error().message();
  return found ? *found : Segmentation{};
}

class PartialPhantom : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto made = build_phantom({});
    ASSERT_TRUE(made) << made.error().message();
    body_ = new Phantom(*made);
    GridOptions coarse;
    coarse.spacing = Vector3d::Constant(4);
    const Grid grid = phantom_grid(*body_, coarse);
    scan_ = new Scan(voxelise(*body_, grid, {.noise_hu = 15}));
  }
  static void TearDownTestSuite() {
    delete scan_;
    delete body_;
  }
  static std::int64_t slice_at(std::string_view landmark, double above = 0) {
    const Vector3d p = body_->landmarks.find(landmark)->second.point + Vector3d(0, 0, above);
    return std::lround(scan_->grey.grid.index(p)[2]);
  }
  static Segmentation found(std::int64_t first, std::int64_t last) {
    return found_in(slices_between(scan_->grey, first, last), 4);
  }
  static void expect_coverage(const Segmentation& found, const std::map<std::string, Coverage>& expected) {
    for (std::size_t n = 1; n < parts.size(); ++n) {
      const auto it = expected.find(std::string(parts[n].name));
      const Coverage should = it == expected.end() ? Coverage::absent : it->second;
      EXPECT_EQ(name_of(found.part[n].coverage), name_of(should)) << parts[n].name;
    }
  }

  static bool by_forest(const Segmentation& found) {
    return std::ranges::any_of(found.warnings, [](const Warning& warning) {
      return warning.text.find("a trained classifier named the parts") != std::string::npos;
    });
  }
  // parts that the forest named: no hip and no shoulder, and at least `least` of the voxels right
  static void expect_rough(const Segmentation& found, std::int64_t first, std::int64_t last, double least) {
    EXPECT_TRUE(by_forest(found));
    for (const std::string joint : {"hip", "shoulder"})
      for (const std::string side : {"_left", "_right"}) EXPECT_FALSE(found.landmarks.contains(joint + side));
    EXPECT_GT(share_right(found.labels, slices_between(scan_->labels, first, last)), least);
  }

  static inline Phantom* body_ = nullptr;
  static inline Scan* scan_ = nullptr;
};

// A round field of view, marked as padding outside, in CT numbers and in densities: it cuts the same parts.
TEST_F(PartialPhantom, NarrowViewCutsDensitiesLikeCtNumbers) {
  GreyVolume hu = scan_->grey, density = hu;
  density.quantity = Quantity::density_kgm3;
  const Grid& g = hu.grid;
  const Vector3d middle = 0.5 * Vector3d(double(g.size[0] - 1), double(g.size[1] - 1), 0);
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const bool out = (g.axes * (Vector3d(double(i), double(j), 0) - middle)).norm() > 150;
        const int v = hu.at(i, j, k);
        density.at(i, j, k) =
            out ? padding_density
                : static_cast<std::int16_t>(std::max(0, v < 100 ? v + 1000 : 1100 + (v - 100) * 4 / 5));
        if (out) hu.at(i, j, k) = padding_hu;
      }
  const Segmentation by_hu = found_in(hu, 4), by_density = found_in(density, 4);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    EXPECT_EQ(name_of(by_density.part[n].coverage), name_of(by_hu.part[n].coverage)) << parts[n].name;
    if (by_hu.part[n].volume > 0 && parts[n].name != "head") {
      EXPECT_EQ(by_hu.part[n].coverage, Coverage::cut) << parts[n].name;
    }
  }
}

TEST_F(PartialPhantom, ScanFromNeckToBelowTheKneesHasCutParts) {
  using enum Coverage;
  expect_coverage(found(slice_at("knee_left", -200), slice_at("neck", 60)), {{"head", cut},
                                                                             {"upper_trunk", whole},
                                                                             {"middle_trunk", whole},
                                                                             {"lower_trunk", whole},
                                                                             {"upper_arm_left", whole},
                                                                             {"upper_arm_right", whole},
                                                                             {"forearm_left", whole},
                                                                             {"forearm_right", whole},
                                                                             {"hand_left", whole},
                                                                             {"hand_right", whole},
                                                                             {"thigh_left", whole},
                                                                             {"thigh_right", whole},
                                                                             {"shank_left", cut},
                                                                             {"shank_right", cut}});
}

TEST_F(PartialPhantom, LegsAloneHaveTheirParts) {
  using enum Coverage;
  const auto legs = found(0, slice_at("hip_left", 130));
  for (const char* side : {"left", "right"}) {
    const auto at = [&](const char* part) {
      return legs.part[static_cast<std::size_t>(part_label(std::string(part) + "_" + side))].coverage;
    };
    EXPECT_EQ(at("foot"), whole);
    EXPECT_EQ(at("shank"), whole);
    EXPECT_EQ(at("thigh"), whole);
    EXPECT_EQ(at("upper_arm"), absent);
  }
  const auto& trunk = legs.part[static_cast<std::size_t>(part_label("lower_trunk"))];
  EXPECT_EQ(trunk.coverage, cut);
  EXPECT_TRUE(trunk.note.starts_with("reaches the edge of the scan")) << trunk.note;
  EXPECT_EQ(legs.part[static_cast<std::size_t>(part_label("head"))].coverage, absent);
}

TEST_F(PartialPhantom, UnrecognisableScanHasNoPartsAndAWarning) {
  const auto feet = found(0, slice_at("ankle_left", 60));
  expect_coverage(feet, {});
  ASSERT_FALSE(feet.warnings.empty());
  EXPECT_NE(feet.warnings.front().text.find("no part was labelled"), std::string::npos);
}

TEST_F(PartialPhantom, KneesAloneHaveRoughParts) {
  const auto first = slice_at("knee_left", -150), last = slice_at("knee_left", 150);
  expect_rough(found(first, last), first, last, 0.8);
}

TEST_F(PartialPhantom, HeadAloneIsAHead) {
  expect_coverage(found(slice_at("neck", 40), scan_->grey.grid.size[2] - 1), {{"head", Coverage::cut}});
}

// Shoulders were once taken for hips, and legs for arms.
TEST_F(PartialPhantom, ChestAndHeadHaveNoHips) {
  using enum Coverage;
  const auto last = scan_->grey.grid.size[2] - 1;
  const std::map<std::string, Coverage> upper{
      {"head", whole},           {"upper_trunk", whole},     {"middle_trunk", cut},
      {"upper_arm_left", whole}, {"upper_arm_right", whole}, {"forearm_left", cut},
      {"forearm_right", cut}};
  const auto top = found(slice_at("elbow_left", -30), last);
  expect_coverage(top, upper);
  EXPECT_LT((top.landmarks.at("shoulder_left").point - body_->landmarks.at("shoulder_left").point).norm(), 4);
  EXPECT_LT((top.landmarks.at("shoulder_right").point - body_->landmarks.at("shoulder_right").point).norm(),
            4);
  // without head and neck: still the upper trunk, and not the lower one
  auto chest = upper;
  chest.erase("head");
  chest["upper_trunk"] = cut;
  expect_coverage(found(slice_at("elbow_left", -30), slice_at("shoulder_left", 50)), chest);
  // from half way down the upper arms
  expect_coverage(found(slice_at("shoulder_left", -100), last),
                  {{"head", whole}, {"upper_trunk", cut}, {"upper_arm_left", cut}, {"upper_arm_right", cut}});
  // neither ribs below the shoulders nor a pair of heads cut by the scan's end are shoulders
  for (const double end : {-60.0, -5.0}) {
    const auto low = slice_at("elbow_left", -30), high = slice_at("shoulder_left", end);
    expect_rough(found(low, high), low, high, 0.8);
  }
}

TEST_F(PartialPhantom, LegsWithCutHipsAreNotArms) {
  using enum Coverage;
  // femoral heads half in view, just in view without the pelvis above, and not in view: thighs say that they
  // may include flesh of the trunk; sockets around the heads may prevent finding thighs at all
  for (const double end : {0.0, 35.0, -60.0}) {
    const auto legs = found(0, slice_at("hip_left", end));
    ASSERT_FALSE(legs.warnings.empty());
    if (end >= 0 && by_forest(legs)) {
      expect_rough(legs, 0, slice_at("hip_left", end), 0.8);
      continue;
    }
    expect_coverage(legs, {{"thigh_left", cut},
                           {"thigh_right", cut},
                           {"shank_left", whole},
                           {"shank_right", whole},
                           {"foot_left", whole},
                           {"foot_right", whole}});
    for (const char* thigh : {"thigh_left", "thigh_right"}) {
      const PartFinding& finding = legs.part[static_cast<std::size_t>(part_label(thigh))];
      EXPECT_LE(finding.confidence, 0.4) << end;
      EXPECT_NE(finding.note.find("may include flesh of the lower trunk"), std::string::npos) << finding.note;
    }
  }
}

TEST_F(PartialPhantom, BellyAboveTheHipsHasNoHips) {
  for (const double from : {0.0, 40.0}) {
    const auto first = slice_at("hip_left", from), last = slice_at("hip_left", 300);
    expect_rough(found(first, last), first, last, 0.8);
  }
}

TEST_F(PartialPhantom, BellyWithHipsHasItsHips) {
  using enum Coverage;
  const auto belly = found(slice_at("hip_left", -45), slice_at("hip_left", 300));
  expect_coverage(belly, {{"middle_trunk", cut},
                          {"lower_trunk", cut},
                          {"thigh_left", cut},
                          {"thigh_right", cut},
                          {"forearm_left", cut},
                          {"forearm_right", cut}});
  EXPECT_LT((belly.landmarks.at("hip_left").point - body_->landmarks.at("hip_left").point).norm(), 4);
}

// The scan ends between armpits and humeral heads: parts that include an arm have a low confidence, and arms
// are labelled or mentioned by warnings.
TEST_F(PartialPhantom, ArmsWithoutShouldersAreNotTrunk) {
  const Segmentation legs_and_arms = found(0, slice_at("shoulder_left", -12));
  for (const char* part : {"middle_trunk", "thigh_left", "thigh_right"}) {
    const auto label = static_cast<std::size_t>(part_label(part));
    const PartFinding& finding = legs_and_arms.part[label];
    double exact = 0;
    for (const std::uint8_t voxel : scan_->labels.voxels) exact += voxel == label;
    const double excess = finding.volume / (exact * scan_->labels.grid.voxel_volume()) - 1;
    EXPECT_TRUE(finding.confidence <= 0.3 || std::abs(excess) < 0.05)
        << part << ": " << excess << " too much at confidence " << finding.confidence;
  }
  // either most of an arm is labelled as that arm, or a warning mentions it
  const LabelMap exact = slices_between(scan_->labels, 0, slice_at("shoulder_left", -12));
  for (const std::string side : {"left", "right"}) {
    double all = 0, right = 0;
    for (std::size_t o = 0; o < exact.voxels.size(); ++o)
      for (const char* part : {"upper_arm_", "forearm_", "hand_"})
        if (exact.voxels[o] == part_label(part + side)) {
          const std::string_view found = parts[legs_and_arms.labels.voxels[o]].name;
          ++all, right += (found.starts_with("upper_arm") || found.starts_with("forearm") ||
                           found.starts_with("hand")) &&
                          found.ends_with(side);
        }
    EXPECT_TRUE(right > 0.9 * all ||
                std::ranges::any_of(legs_and_arms.warnings,
                                    [&](const Warning& warning) {
                                      return warning.severity != Severity::note &&
                                             (warning.text.find(side + " arm") != std::string::npos ||
                                              warning.text.find("whose shoulders are not in view") !=
                                                  std::string::npos);
                                    }))
        << side << ": " << right / all;
  }
}

TEST_F(PartialPhantom, CutForearmsHaveNoWrists) {
  for (const double above : {8.0, 20.0}) {
    const Segmentation upper = found(slice_at("wrist_left", above), scan_->grey.grid.size[2] - 1);
    for (const std::string side : {"_left", "_right"}) {
      EXPECT_FALSE(upper.landmarks.contains("wrist" + side)) << above;
      EXPECT_EQ(name_of(upper.part[static_cast<std::size_t>(part_label("forearm" + side))].coverage), "cut");
      EXPECT_EQ(name_of(upper.part[static_cast<std::size_t>(part_label("hand" + side))].coverage), "absent");
    }
  }
}

TEST_F(PartialPhantom, CutHumeralHeadsAreReported) {
  for (const double above : {0.0, 8.0, 16.0}) {
    const Segmentation lower = found(slice_at("hip_left", -60), slice_at("shoulder_left", above));
    for (const std::string name : {"shoulder_left", "shoulder_right"}) {
      const auto it = lower.landmarks.find(name);
      if (it == lower.landmarks.end()) continue;
      const Vector3d off = it->second.point - body_->landmarks.at(name).point;
      EXPECT_LT(off.cwiseAbs().maxCoeff(), 2 * it->second.deviation) << name << " " << above;
    }
  }
}

// The pelvis is in view to below the iliac spines, but the femoral heads are not: planes through the spines
// cut off the thighs.
TEST_F(PartialPhantom, HipsBelowTheScanComeFromRegressions) {
  using enum Coverage;
  const auto first = slice_at("hip_left", 45), last = scan_->grey.grid.size[2] - 1;
  const Segmentation cut_above = found(first, last);
  for (const std::string side : {"_left", "_right"}) {
    const Landmark& hip = cut_above.landmarks.at("hip" + side);
    EXPECT_TRUE(hip.source.starts_with("regression: Harrington 2007 by pelvis width")) << hip.source;
    const Vector3d off = hip.point - body_->landmarks.find("hip" + side)->second.point;
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 2 * hip.deviation) << off.transpose();
    EXPECT_GT(hip.deviation, 8);
    const auto& thigh = cut_above.part[static_cast<std::size_t>(part_label("thigh" + side))];
    EXPECT_EQ(name_of(thigh.coverage), "cut");
    EXPECT_NE(thigh.note.find("placed by regression"), std::string::npos) << thigh.note;
  }
  const auto agreement = dice(cut_above.labels, slices_between(scan_->labels, first, last));
  for (const char* part : {"lower_trunk", "middle_trunk", "thigh_left", "thigh_right"})
    EXPECT_GT(agreement[static_cast<std::size_t>(part_label(part))], 0.9) << part;
}

// the ICRP male and the segmentation of his whole scan
class PartialIcrp : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const std::string icrp = test::shared_folder() + "/volumes/icrp_am/AM_hu.nii.gz";
    if (!std::filesystem::exists(icrp)) return;
    auto scan = read_volume(icrp);
    ASSERT_TRUE(scan) << scan.error().message();
    scan_ = new GreyVolume(std::move(scan->volume));
    whole_ = new Segmentation(found_in(*scan_));
  }
  static void TearDownTestSuite() {
    delete scan_;
    delete whole_;
  }
  void SetUp() override {
    if (!scan_) GTEST_SKIP() << "the ICRP male is not beside the checkout";
  }
  static inline GreyVolume* scan_ = nullptr;
  static inline Segmentation* whole_ = nullptr;
};

TEST_F(PartialIcrp, HipsByRegressionMatchHisFemoralHeads) {
  const Vector3d head = whole_->landmarks.at("hip_left").point;
  const auto first = std::lround(scan_->grid.index(head + Vector3d(0, 0, 35))[2]);
  const Segmentation upper = found_in(slices_between(*scan_, first, scan_->grid.size[2] - 1));
  for (const std::string side : {"_left", "_right"}) {
    ASSERT_TRUE(upper.landmarks.contains("hip" + side));
    const Landmark& hip = upper.landmarks.at("hip" + side);
    EXPECT_TRUE(hip.source.starts_with("regression")) << hip.source;
    const Vector3d off = hip.point - whole_->landmarks.at("hip" + side).point;
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 2 * hip.deviation) << off.transpose();
  }
}

// The upper 45 % and a chest: hips with thighs below were once found in them. The visible part of the thighs
// lies above the femoral heads, outside the planes through the iliac spines.
TEST_F(PartialIcrp, UpperHalfAndChestHaveNoLegs) {
  const auto slices = scan_->grid.size[2];
  const auto first = slices * 55 / 100;
  for (const auto last : {slices - 1, slices * 84 / 100}) {
    const Segmentation found = found_in(slices_between(*scan_, first, last));
    const auto agreement = dice(found.labels, slices_between(whole_->labels, first, last));
    for (std::size_t n = 1; n < parts.size(); ++n) {
      const std::string name(parts[n].name);
      const bool below = name.starts_with("shank") || name.starts_with("foot");
      EXPECT_EQ(found.part[n].coverage == Coverage::absent,
                below || name.starts_with("hand") || (name == "head" && last < slices - 1))
          << name;
      if (name.starts_with("thigh") || name == "lower_trunk") {
        EXPECT_EQ(found.part[n].coverage, Coverage::cut) << name;
        EXPECT_GT(agreement[n], 0.9) << name;
      }
    }
  }
}

// A joint's plane bisects the angle even if the next joint is not in view. (With an elbow's plane
// perpendicular to the upper arm and none at the knee, Dice would be .69 and .96.)
TEST(PartialBody, CutForearmsAndShanksStayBehindTheirJoints) {
  struct Case {
    std::uint64_t variation;
    std::map<std::string, double> pose;
    Vector3d low, high;  // mm, of the crop
    std::array<std::string, 4> parts;
  };
  for (const Case& c : {Case{91,
                             {{"elbow_left_flexion", 90}, {"elbow_right_flexion", 90}},
                             {-400, -160, 700},
                             {400, 300, 2000},
                             {"upper_arm_left", "upper_arm_right", "forearm_left", "forearm_right"}},
                        Case{24,
                             {},
                             {-400, -300, 250},
                             {400, 300, 1100},
                             {"thigh_left", "thigh_right", "shank_left", "shank_right"}}}) {
    SCOPED_TRACE(c.variation);
    PhantomOptions of;
    of.variation = c.variation, of.pose_deg = c.pose;
    const auto body = build_phantom(of);
    ASSERT_TRUE(body);
    GridOptions grid;
    grid.spacing.setConstant(4);
    for (int axis = 0; axis < 3; ++axis)
      grid.crop_low[axis] = c.low[axis], grid.crop_high[axis] = c.high[axis];
    ScanOptions as;
    as.noise_hu = 10;
    const Scan scan = voxelise(*body, phantom_grid(*body, grid), as);
    const Segmentation found = found_in(scan.grey);
    const auto agree = dice(found.labels, scan.labels);
    for (const std::string& part : c.parts)
      EXPECT_GT(agree[static_cast<std::size_t>(part_label(part))], 0.97) << part;
  }
}

}  // namespace
}  // namespace borelli::partial_scan_test
