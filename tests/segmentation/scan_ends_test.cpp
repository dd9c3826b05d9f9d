// Scans that end where parts are hard to distinguish: within the hips, in the sternum, above the knees, in
// fingers and toes, beside hips, shoulders and knees. The parts in view, against the phantom's exact labels.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "tests/segmentation/dice.hpp"
#include "tests/segmentation/scanned_body.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// `to` sets the grid's ends from the body's exact landmarks
template <class To>
ScannedBody scanned(std::uint64_t variation, const To& to) {
  const auto grid_of = [&](const Phantom& body) {
    GridOptions grid;
    grid.spacing.setConstant(4);
    to(grid, [&](const char* name) { return body.landmarks.find(name)->second.point; });
    return grid;
  };
  return scanned_body(variation, Sex::male, grid_of);
}

const PartFinding& part(const ScannedBody& of, std::string_view name) {
  return of.found.part[static_cast<std::size_t>(part_label(name))];
}

double volume(const LabelMap& labels, std::string_view name) {
  return labels.grid.voxel_volume() *
         static_cast<double>(std::count(labels.voxels.begin(), labels.voxels.end(), part_label(name)));
}

// The scan's lower end cuts the hips, or lies above them with the iliac spines in view: thighs are still
// found.
TEST(ScanEnds, WithinAndBelowTheHips) {
  for (const std::uint64_t variation : {21, 58})
    for (const double above : {-22, -8, 16, 40}) {
      const ScannedBody of = scanned(variation, [&](GridOptions& grid, const auto& mark) {
        grid.crop_low[2] = mark("mid_hip")[2] + above;
      });
      const auto agree = dice(of.found.labels, of.exact);
      for (const char* name : {"lower_trunk", "thigh_left", "thigh_right"}) {
        EXPECT_GT(agree[static_cast<std::size_t>(part_label(name))], above < 0 ? 0.98 : 0.88)
            << variation << ' ' << above << ' ' << name;
        EXPECT_EQ(name_of(part(of, name).coverage), "cut");
      }
      EXPECT_NEAR(part(of, "lower_trunk").volume / volume(of.exact, "lower_trunk"), 1, 0.04)
          << variation << ' ' << above;
      for (const auto& [name, found] : of.found.landmarks) {
        const auto exact = of.body.landmarks.find(name);
        if (exact == of.body.landmarks.end() || !(name.starts_with("hip") || name.starts_with("asis")))
          continue;
        EXPECT_LT((found.point - exact->second.point).norm(), 2 * found.deviation) << name;
      }
    }
}

// Without hips and iliac spines, the thighs' upper ends are unknown: the part that includes them has a note.
TEST(ScanEnds, AtTheIliacCrests) {
  const ScannedBody of =
      scanned(21, [&](GridOptions& grid, const auto& mark) { grid.crop_low[2] = mark("asis_left")[2] + 6; });
  EXPECT_FALSE(of.found.landmarks.contains("asis_left"));
  EXPECT_LE(part(of, "lower_trunk").confidence, 0.4);
  EXPECT_NE(part(of, "lower_trunk").note.find("may include flesh of the thighs"), std::string::npos);
  EXPECT_GT(part(of, "middle_trunk").confidence, 0.8);
}

// The point where the sternum leaves the scan at the front is not its lower end.
TEST(ScanEnds, InTheBreastbone) {
  const ScannedBody of = scanned(77, [&](GridOptions& grid, const auto& mark) {
    grid.crop_low[1] = 0.5 * (mark("suprasternale")[1] + mark("xiphion")[1]);
  });
  const auto& xiphion = of.found.landmarks.at("xiphion");
  EXPECT_TRUE(xiphion.source.starts_with("proportion")) << xiphion.source;
  EXPECT_LT(std::abs(xiphion.point[2] - of.body.landmarks.find("xiphion")->second.point[2]),
            2 * xiphion.deviation);
  const auto agree = dice(of.found.labels, of.exact);
  for (const char* name : {"upper_trunk", "middle_trunk", "lower_trunk", "thigh_left", "thigh_right"}) {
    EXPECT_GT(agree[static_cast<std::size_t>(part_label(name))], 0.95) << name;
    EXPECT_EQ(name_of(part(of, name).coverage), "cut") << name;
  }
}

// Nor is the point where it leaves the scan at the bottom.
TEST(ScanEnds, AboveTheXiphion) {
  for (const double above : {20.0, 60.0}) {
    const ScannedBody of = scanned(
        201, [&](GridOptions& grid, const auto& mark) { grid.crop_low[2] = mark("xiphion")[2] + above; });
    EXPECT_FALSE(of.found.landmarks.contains("xiphion"));
    EXPECT_EQ(name_of(part(of, "upper_trunk").coverage), "cut");
    EXPECT_EQ(part(of, "middle_trunk").volume, 0);
  }
}

// A femur that widens towards a knee outside the scan gets no knee, and no shank beyond.
TEST(ScanEnds, AboveTheKnees) {
  for (const double above : {10.0, 35.0}) {
    const ScannedBody of = scanned(201, [&](GridOptions& grid, const auto& mark) {
      grid.crop_low[2] = std::max(mark("knee_left")[2], mark("knee_right")[2]) + above;
    });
    for (const std::string side : {"_left", "_right"}) {
      EXPECT_FALSE(of.found.landmarks.contains("knee" + side)) << above;
      EXPECT_EQ(part(of, "shank" + side).volume, 0) << above;
      EXPECT_EQ(name_of(part(of, "thigh" + side).coverage), "cut") << above;
    }
  }
}

// Fingers and toes are so thin that depth does not show a cut; hands and feet that just reach the scan's end
// are whole.
TEST(ScanEnds, InFingersAndToes) {
  for (const double beyond : {-1.0, 8.0, 40.0}) {  // mm cut off the lowest fingertip and the toes
    const auto lowest = [](const auto& mark) {
      return std::min(mark("dactylion_3_left")[2], mark("dactylion_3_right")[2]);
    };
    const ScannedBody hands =
        scanned(41, [&](GridOptions& grid, const auto& mark) { grid.crop_low[2] = lowest(mark) + beyond; });
    const ScannedBody feet = scanned(41, [&](GridOptions& grid, const auto& mark) {
      grid.crop_low[1] = std::min(mark("toe_tip_left")[1], mark("toe_tip_right")[1]) + beyond;
      grid.crop_high[2] = mark("mid_hip")[2] - 150;
    });
    for (const char* side : {"_left", "_right"}) {
      const auto check = [&](const ScannedBody& of, const std::string& name, const std::string& end) {
        const int axis = name == "hand" ? 2 : 1;
        const double beyond_edge =
            of.found.labels.grid.origin[axis] - 2 - of.body.landmarks.find(end + side)->second.point[axis];
        if (beyond_edge > 0 && beyond_edge < 4) return;  // a voxel more or less
        const bool cut = beyond_edge > 0;
        EXPECT_EQ(name_of(part(of, name + side).coverage), cut ? "cut" : "whole") << name << side << beyond;
        if (cut) {
          EXPECT_FALSE(of.found.landmarks.contains(end + side)) << name << side << beyond;
        }
      };
      check(hands, "hand", "dactylion_3");
      check(feet, "foot", "toe_tip");
    }
  }
}

// The scan's side cuts a femur's neck and the shoulder above: both hips are true heads, and the visible
// shoulder is found without the other.
TEST(ScanEnds, BesideAHip) {
  for (const std::uint64_t variation : {21, 58}) {
    const ScannedBody of = scanned(variation, [&](GridOptions& grid, const auto& mark) {
      grid.crop_high[0] = mark("hip_left")[0] + 30;
      grid.crop_low[2] = mark("mid_hip")[2] - 60;
    });
    const auto agree = dice(of.found.labels, of.exact);
    for (const char* name : {"head", "upper_trunk", "middle_trunk", "lower_trunk", "thigh_left",
                             "thigh_right", "upper_arm_right", "forearm_right"})
      EXPECT_GT(agree[static_cast<std::size_t>(part_label(name))], 0.95) << variation << ' ' << name;
    EXPECT_EQ(part(of, "upper_arm_left").volume, 0) << variation;
    for (const char* joint : {"hip_left", "hip_right", "shoulder_right"})
      EXPECT_LT((of.found.landmarks.at(joint).point - of.body.landmarks.find(joint)->second.point).norm(), 3)
          << variation << ' ' << joint;
  }
}

// Ribs at the scan's side, beyond which a shoulder lies, are not its head.
TEST(ScanEnds, BesideAShoulder) {
  for (const double inwards : {0.0, 20.0, 45.0}) {
    const ScannedBody of = scanned(201, [&](GridOptions& grid, const auto& mark) {
      grid.crop_high[0] = mark("shoulder_left")[0] - inwards;
      grid.crop_low[2] = mark("mid_hip")[2] - 60;
    });
    EXPECT_LE(part(of, "upper_arm_left").volume, 1.1 * volume(of.exact, "upper_arm_left")) << inwards;
    const auto shoulder = of.found.landmarks.find("shoulder_left");
    if (shoulder != of.found.landmarks.end()) {
      EXPECT_LT((shoulder->second.point - of.body.landmarks.find("shoulder_left")->second.point).norm(),
                2 * shoulder->second.deviation)
          << inwards;
    }
    EXPECT_LT((of.found.landmarks.at("shoulder_right").point -
               of.body.landmarks.find("shoulder_right")->second.point)
                  .norm(),
              3)
        << inwards;
    const auto agree = dice(of.found.labels, of.exact);
    for (const char* name : {"upper_trunk", "upper_arm_right", "forearm_right"})
      EXPECT_GT(agree[static_cast<std::size_t>(part_label(name))], 0.95) << inwards << ' ' << name;
  }
}

// A thigh whose knee is beyond the scan's side, with pieces of the shank in view, is not called a whole
// thigh.
TEST(ScanEnds, BesideAKnee) {
  const ScannedBody of = scanned(
      401, [&](GridOptions& grid, const auto& mark) { grid.crop_high[0] = mark("hip_left")[0] + 21; });
  ASSERT_GT(volume(of.exact, "shank_left"), 0.2e6);
  EXPECT_EQ(part(of, "shank_left").volume, 0);
  EXPECT_LE(part(of, "thigh_left").confidence, 0.2);
  EXPECT_NE(part(of, "thigh_left").note.find("this part includes the visible part of the shank and foot"),
            std::string::npos);
  EXPECT_GT(part(of, "thigh_right").confidence, 0.7);
}

// If little of a hand is in view, large voxels show no wrist; the estimated wrist's deviation covers the
// distance to the scan's end.
TEST(ScanEnds, JustBelowTheWrists) {
  for (const double below : {20.0, 35.0}) {
    const ScannedBody of = scanned(202, [&](GridOptions& grid, const auto& mark) {
      grid.crop_low[2] = std::min(mark("wrist_left")[2], mark("wrist_right")[2]) - below;
    });
    for (const std::string side : {"_left", "_right"}) {
      const auto wrist = of.found.landmarks.find("wrist" + side);
      if (wrist == of.found.landmarks.end()) continue;
      const double off = (wrist->second.point - of.body.landmarks.find("wrist" + side)->second.point).norm();
      EXPECT_LT(off, 2 * wrist->second.deviation) << below << side;
      if (off > 20) {
        EXPECT_LT(part(of, "forearm" + side).confidence, 0.5) << below << side;
      }
    }
  }
}

// Raised arms: a body in a pose, with the scan's part of it.
ScannedBody raised(std::uint64_t variation, std::map<std::string, double> pose, const Vector3d& low,
                   const Vector3d& high) {
  PhantomOptions options;
  options.variation = variation;
  options.pose_deg = std::move(pose);
  auto body = build_phantom(options);
  EXPECT_TRUE(body);
  GridOptions grid;
  grid.spacing.setConstant(3);
  grid.crop_low = low, grid.crop_high = high;
  ScanOptions as;
  as.partial_volume = true, as.noise_hu = 12;
  const Scan scan = voxelise(*body, phantom_grid(*body, grid), as);
  auto found = segment(scan.grey);
  EXPECT_TRUE(found);
  return {*body, scan.labels, *found};
}

// If the scan ends above the elbows of raised, bent arms, the visible forearms show which side is medial.
TEST(ScanEnds, AboveRaisedElbows) {
  const ScannedBody of = raised(931,
                                {{"shoulder_left_abduction", 150},
                                 {"shoulder_right_abduction", 145},
                                 {"elbow_left_flexion", 50},
                                 {"elbow_right_flexion", 60}},
                                {-500, -400, 880}, {500, 400, 1740});
  for (const std::string side : {"_left", "_right"}) {
    EXPECT_FALSE(of.found.landmarks.contains("wrist" + side));
    const auto axis = [&](const auto& marks) -> Vector3d {
      return (marks.at("elbow_lateral" + side).point - marks.at("elbow_medial" + side).point).normalized();
    };
    EXPECT_GT(axis(of.found.landmarks).dot(axis(of.body.landmarks)), std::cos(10 * M_PI / 180)) << side;
  }
}

// Raised arms leave the scan at its side at the elbow and come back: parts that include their flesh have a
// low confidence.
TEST(ScanEnds, BesideRaisedElbows) {
  const ScannedBody arms = raised(911,
                                  {{"shoulder_left_abduction", 110},
                                   {"shoulder_right_abduction", 115},
                                   {"elbow_left_flexion", 90},
                                   {"elbow_right_flexion", 100}},
                                  {-400, -400, 850}, {400, 400, 3000});
  ASSERT_GT(volume(arms.exact, "forearm_right"), 0.4e6);
  EXPECT_EQ(part(arms, "forearm_right").volume, 0);
  EXPECT_LE(part(arms, "upper_arm_right").confidence, 0.2);
  EXPECT_GT(part(arms, "upper_arm_left").confidence, 0.8);
  const ScannedBody head = raised(
      917, {{"shoulder_left_abduction", 120}, {"shoulder_left_rotation", -85}, {"elbow_left_flexion", 115}},
      {-400, -400, 850}, {250, 400, 3000});
  ASSERT_GT(volume(head.exact, "hand_left"), 0.2e6);
  EXPECT_EQ(part(head, "hand_left").volume, 0);
  EXPECT_LE(part(head, "head").confidence, 0.2);
  if (const auto vertex = head.found.landmarks.find("vertex"); vertex != head.found.landmarks.end()) {
    EXPECT_LT((vertex->second.point - head.body.landmarks.at("vertex").point).norm(),
              2 * vertex->second.deviation);
  }
}

}  // namespace
}  // namespace borelli
