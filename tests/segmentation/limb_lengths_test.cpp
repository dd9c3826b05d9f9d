// Joints that make a limb unlike the other side's are doubted; real bodies' sides are not.
#include "segmentation/joints/limb_lengths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli::limb_lengths_test {
namespace {

using Eigen::Vector3d;

// hips and shoulders of an average adult; limbs as in the phantom
struct Body {
  Trunk trunk;
  Limbs limbs;
  Landmarks marks;

  Body() {
    auto made = build_phantom({});
    EXPECT_TRUE(made);
    marks = made->landmarks;
    for (auto& [name, mark] : marks) mark.deviation = 2, mark.source = "bone: found";
    for (const int side : {left_side, right_side}) {
      const std::string at = side_suffix(side);
      const auto n = static_cast<std::size_t>(side);
      trunk.hip[n] = FoundSphere{marks["hip" + at].point, 24, 1, 0.5};
      trunk.shoulder[n] = FoundSphere{marks["shoulder" + at].point, 24, 1, 0.5};
    }
  }
  // moves a joint along the line from the one before it
  void lengthen(const std::string& from, const std::string& to, double by) {
    Vector3d& end = marks[to].point;
    end += by * (end - marks[from].point).normalized();
  }
  const Landmark& doubted(const std::string& name) {
    doubt_unlike_lengths(trunk, limbs, marks);
    return marks[name];
  }
};

TEST(LimbLengths, AcceptsSidesThatDifferByThreePercent) {
  Body body;
  const Landmarks before = body.marks;
  const auto length = [&](const char* from, const char* to) {
    return (body.marks[to].point - body.marks[from].point).norm();
  };
  for (const auto& [from, to, moved] : {std::array{"hip_left", "knee_left", "ankle_left"},
                                        {"shoulder_right", "elbow_right", "wrist_right"}}) {
    const Vector3d old = body.marks[to].point;
    body.lengthen(from, to, 0.03 * length(from, to));
    body.marks[moved].point += body.marks[to].point - old;
  }
  body.lengthen("elbow_left", "wrist_left", 0.03 * length("elbow_left", "wrist_left"));
  body.lengthen("knee_right", "ankle_right", 0.03 * length("knee_right", "ankle_right"));
  doubt_unlike_lengths(body.trunk, body.limbs, body.marks);
  for (const auto& [name, mark] : body.marks) {
    EXPECT_EQ(mark.deviation, before.at(name).deviation) << name;
    EXPECT_EQ(mark.source, "bone: found") << name;
  }
}

TEST(LimbLengths, DoubtsTheLessCertainSide) {
  Body body;
  body.lengthen("hip_right", "knee_right", -30);
  body.marks["knee_right"].deviation = 9.5;
  EXPECT_NEAR(body.doubted("knee_right").deviation, 30, 0.1);
  EXPECT_TRUE(body.marks["knee_right"].source.ends_with(unlike_other_side));
  EXPECT_EQ(body.marks["knee_left"].deviation, 2);
  // the shank is not compared while its knee is in doubt
  EXPECT_EQ(body.marks["ankle_right"].deviation, 2);
}

TEST(LimbLengths, DoubtsItsEpicondylesToo) {
  Body body;
  body.lengthen("hip_right", "knee_right", -30);
  body.marks["knee_right"].deviation = 9.5;
  EXPECT_NEAR(body.doubted("knee_medial_right").deviation, 30, 0.1);
  EXPECT_NEAR(body.marks["knee_lateral_right"].deviation, 30, 0.1);
  EXPECT_EQ(body.marks["knee_lateral_left"].deviation, 2);
}

// On large voxels the joint with the smaller deviation may be a cylinder fitted to another bone.
TEST(LimbLengths, DoubtsBothSidesOnLargeVoxels) {
  Body body;
  body.lengthen("hip_left", "knee_left", 30);
  body.marks["knee_right"].deviation = 9.5;
  doubt_unlike_lengths(body.trunk, body.limbs, body.marks, true);
  EXPECT_NEAR(body.marks["knee_left"].deviation, 30, 0.1);
  EXPECT_NEAR(body.marks["knee_right"].deviation, 30, 0.1);
}

TEST(LimbLengths, DoubtsALengthUnlikelyForTheBody) {
  Body body;
  body.lengthen("elbow_right", "wrist_right", -93);
  EXPECT_NEAR(body.doubted("wrist_right").deviation, 93, 0.1);
  EXPECT_EQ(body.marks["wrist_left"].deviation, 2);
}

TEST(LimbLengths, DoubtsBothTouchingArms) {
  Body body;
  body.limbs.arms_meet = true;
  body.lengthen("elbow_right", "wrist_right", -93);
  EXPECT_NEAR(body.doubted("wrist_right").deviation, 93, 0.1);
  EXPECT_NEAR(body.marks["wrist_left"].deviation, 93, 0.1);
}

TEST(LimbLengths, DoubtsBothSidesUnlikelyForTheBody) {
  Body body;
  for (const char* side : {"_left", "_right"})
    body.lengthen("knee" + std::string(side), "ankle" + std::string(side), -150);
  EXPECT_GT(body.doubted("ankle_left").deviation, 100);
  EXPECT_TRUE(body.marks["ankle_right"].source.ends_with(unlike_body));
}

TEST(LimbLengths, ComparesAForearmWithItsUpperArmWithoutHips) {
  Body body;
  body.trunk.hip = {};
  for (const char* side : {"_left", "_right"})
    body.lengthen("elbow" + std::string(side), "wrist" + std::string(side), -67);
  EXPECT_NEAR(body.doubted("wrist_left").deviation, 67, 2);
  EXPECT_TRUE(body.marks["wrist_right"].source.ends_with(unlike_body));
}

struct Scanned {
  Phantom body;
  Segmentation found;
};

Scanned scanned(std::uint64_t variation, Sex sex, const GridOptions& grid, double field_of_view = 0,
                const std::map<std::string, double>& pose_deg = {}) {
  PhantomOptions of;
  of.sex = sex;
  of.variation = variation;
  of.pose_deg = pose_deg;
  auto body = build_phantom(of);
  EXPECT_TRUE(body);
  ScanOptions as;
  as.noise_hu = 10, as.partial_volume = true, as.field_of_view = field_of_view;
  const Scan scan = voxelise(*body, phantom_grid(*body, grid), as);
  auto found = segment(scan.grey);
  EXPECT_TRUE(found);
  return {*body, *found};
}

double off(const Scanned& of, const std::string& name) {
  return (of.found.landmarks.find(name)->second.point - of.body.landmarks.find(name)->second.point).norm();
}

bool warns(const Scanned& of, const std::string& text) {
  return std::any_of(of.found.warnings.begin(), of.found.warnings.end(),
                     [&](const Warning& warning) { return warning.text.find(text) != std::string::npos; });
}

GridOptions voxels(double edge) {
  GridOptions grid;
  grid.spacing = Vector3d::Constant(edge);
  return grid;
}

// A patella in front of broad condyles, and a narrow plateau below: the narrowest level between them is the
// joint line.
TEST(LimbLengths, MeasuresAKneeBehindAPatella) {
  const Scanned of = scanned(9, Sex::female, voxels(3));
  for (const char* knee : {"knee_left", "knee_right"}) EXPECT_LT(off(of, knee), 3) << knee;
  EXPECT_FALSE(warns(of, "unlike"));
}

// The field of view cuts along the shank's bones to the heel. Their narrowing is not a shaft, and the foot's
// bones are not an ankle.
TEST(LimbLengths, PlacesACutAnkleByTheOtherLeg) {
  const Scanned of = scanned(40, Sex::male, voxels(4), 380);
  const auto& ankle = of.found.landmarks.find("ankle_left")->second;
  EXPECT_TRUE(ankle.source.starts_with("proportion"));
  for (int c = 0; c < 3; ++c)
    EXPECT_LT(std::abs((ankle.point - of.body.landmarks.find("ankle_left")->second.point)[c]),
              2 * ankle.deviation);
  EXPECT_EQ(name_of(of.found.part[static_cast<std::size_t>(part_label("foot_left"))].coverage), "cut");
  EXPECT_LT(off(of, "ankle_right"), 3);
}

// The scan ends at the elbows: a widening shaft is not an elbow.
TEST(LimbLengths, FindsNoElbowIfTheScanEndsAboveIt) {
  GridOptions grid = voxels(4);
  grid.crop_low[2] = 1150, grid.crop_high[2] = 1500;
  const Scanned of = scanned(40, Sex::male, grid);
  EXPECT_GT(of.body.landmarks.find("elbow_right")->second.point[2], 1130);  // it lies near the end
  for (const char* side : {"_left", "_right"}) {
    // the visible part of a forearm may place one by proportion
    const auto elbow = of.found.landmarks.find("elbow" + std::string(side));
    if (elbow != of.found.landmarks.end()) {
      EXPECT_TRUE(elbow->second.source.starts_with("proportion")) << elbow->second.source;
      const Vector3d error =
          elbow->second.point - of.body.landmarks.find("elbow" + std::string(side))->second.point;
      for (int c = 0; c < 3; ++c) EXPECT_LT(std::abs(error[c]), 2 * elbow->second.deviation) << side;
    }
    EXPECT_EQ(
        name_of(
            of.found.part[static_cast<std::size_t>(part_label("upper_arm" + std::string(side)))].coverage),
        "cut");
  }
}

// Forearms whose bones touch: their wrists are right, or a warning names them.
TEST(LimbLengths, TouchingForearmsAreRightOrDoubted) {
  const Scanned of = scanned(75, Sex::male, voxels(3), 0,
                             {{"shoulder_left_flexion", 20},
                              {"shoulder_left_rotation", 65},
                              {"elbow_left_flexion", 100},
                              {"shoulder_right_flexion", 30},
                              {"shoulder_right_rotation", 65},
                              {"elbow_right_flexion", 110}});
  for (const char* side : {"left", "right"}) {
    const std::string wrist = std::string("wrist_") + side;
    EXPECT_LT(off(of, wrist), 2 * of.found.landmarks.find(wrist)->second.deviation) << wrist;
    constexpr double right = 10;  // mm
    if (off(of, wrist) < right) continue;
    EXPECT_TRUE(warns(of, side + std::string(" wrist may lie")));
    EXPECT_LT(of.found.part[static_cast<std::size_t>(part_label(std::string("hand_") + side))].confidence,
              0.1);
  }
}

}  // namespace
}  // namespace borelli::limb_lengths_test
