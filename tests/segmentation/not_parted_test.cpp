// Messages about limbs whose joints were not found, on a complete body.
#include <gtest/gtest.h>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/segmentation/dice.hpp"

namespace borelli {
namespace {

TEST(NotParted, PartWithItsNeighbourIsNotWhole) {
  const auto phantom = build_phantom({});
  ASSERT_TRUE(phantom);
  GridOptions options;
  options.spacing = {6, 6, 6};
  Scan made = voxelise(*phantom, phantom_grid(*phantom, options));
  GreyVolume& scan = made.grey;
  // forearms and hands without bones: elbows and wrists cannot be found
  for (std::size_t o = 0; o < scan.voxels.size(); ++o) {
    const int label = made.labels.voxels[o];
    if (label >= part_label("forearm_left") && label <= part_label("hand_right") && scan.voxels[o] > 100)
      scan.voxels[o] = 45;
  }
  scan.grid.size[2] = scan.grid.size[2] * 85 / 100;  // without the head
  scan.voxels.resize(scan.grid.count());
  const auto found = segment(scan, {.step = 4});
  ASSERT_TRUE(found) << found.error().message();
  int not_parted = 0;
  for (std::size_t n = 5; n < parts.size(); ++n) {
    const PartFinding& finding = found->part[n];
    EXPECT_NE(finding.coverage, Coverage::absent) << parts[n].name;  // the phantom is complete below the neck
    if (finding.volume > 0) continue;
    ++not_parted;
    EXPECT_EQ(finding.coverage, Coverage::cut) << parts[n].name;
    EXPECT_NE(finding.note.find("included in the "), std::string::npos) << finding.note;
    for (std::size_t p = 5; p < parts.size(); ++p)
      if (parts[p].name == parts[n].parent && found->part[p].volume > 0) {
        EXPECT_EQ(found->part[p].coverage, Coverage::cut) << parts[p].name;
        EXPECT_LE(found->part[p].confidence, 0.2) << parts[p].name;
        EXPECT_TRUE(found->part[p].note.find("was found: this part includes the ") != std::string::npos)
            << found->part[p].note;
      }
  }
  EXPECT_GE(not_parted, 2);  // at least a forearm or hand on each side
}

// If one wrist lies on the other, a hand's bones are assigned to the wrong arm. Then neither hand counts as
// certain, and the upper arm still ends at its elbow although its forearm has no wrist.
TEST(NotParted, TouchingHandsAreDoubted) {
  PhantomOptions options;
  options.variation = 5302;
  options.sex = Sex::female;
  options.pose_deg = {{"shoulder_left_flexion", 15},   {"shoulder_left_abduction", 8},
                      {"shoulder_left_rotation", 45},  {"elbow_left_flexion", 80},
                      {"shoulder_right_flexion", 12},  {"shoulder_right_abduction", 8},
                      {"shoulder_right_rotation", 50}, {"elbow_right_flexion", 85}};
  const auto phantom = build_phantom(options);
  ASSERT_TRUE(phantom);
  GridOptions grid;
  grid.spacing = {3, 3, 3};
  const Scan scan = voxelise(*phantom, phantom_grid(*phantom, grid), {.noise_hu = 12});
  const auto found = segment(scan.grey);
  ASSERT_TRUE(found) << found.error().message();
  const auto agree = dice(found->labels, scan.labels);
  for (const std::string side : {"_left", "_right"}) {
    const auto hand = static_cast<std::size_t>(part_label("hand" + side));
    if (agree[hand] < 0.9) {
      EXPECT_EQ(found->part[hand].coverage, Coverage::cut) << side;
      EXPECT_LE(found->part[hand].confidence, 0.1) << side;
      EXPECT_FALSE(found->landmarks.contains("dactylion_3" + side));
    }
    EXPECT_GT(agree[static_cast<std::size_t>(part_label("upper_arm" + side))], 0.98) << side;
  }
}

}  // namespace
}  // namespace borelli
