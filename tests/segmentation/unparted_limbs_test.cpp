// Limb parts that hold the next part too.
#include "segmentation/labelling/unparted_limbs.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/segmentation/proposal/drawn_body.hpp"
#include "tests/segmentation/slices_between.hpp"

namespace borelli::unparted_limbs_test {
namespace {

constexpr auto forearm = static_cast<std::size_t>(part_label("forearm_left")),
               hand = static_cast<std::size_t>(part_label("hand_left"));

// Slice of the drawn body at a landmark.
std::int64_t slice_at(const char* landmark) {
  PhantomOptions options;
  options.stature_m = 1.3;
  return std::lround(
      proposal_test::drawn().grey.grid.index(build_phantom(options)->landmarks.at(landmark).point)[2]);
}

// The drawn body's slices from `first` to `last`. The hand has the forearm's label.
Segmentation judged(std::int64_t first, std::int64_t last) {
  const GreyVolume scan = slices_between(proposal_test::drawn().grey, first, last);
  Segmentation out;
  out.labels = slices_between(proposal_test::drawn().parts, first, last);
  for (auto& label : out.labels.voxels)
    if (label == hand) label = forearm;
  out.part[forearm] = {Coverage::cut, 1e5, 1, "reaches the edge of the scan"};
  doubt_jointless_limbs(anatomy_of(scan, 4, 0), out);
  return out;
}

TEST(UnpartedLimbs, ForearmsWithoutJointsMayIncludeTheHand) {
  const auto wrist = slice_at("wrist_left"), middle = (slice_at("elbow_left") + wrist) / 2;
  const Segmentation whole_hand = judged(slice_at("dactylion_3_left") - 15, middle);
  EXPECT_LE(whole_hand.part[forearm].confidence, 0.2);
  EXPECT_NE(whole_hand.part[forearm].note.find("no wrist was found: this part includes the hand"),
            std::string::npos);
  EXPECT_EQ(whole_hand.part[hand].coverage, Coverage::cut);
  EXPECT_EQ(whole_hand.part[hand].note, "included in the forearm: no wrist was found");

  const Segmentation cut_twice = judged(wrist + 5, middle + 5);
  EXPECT_EQ(cut_twice.part[forearm].confidence, 0.4);
  EXPECT_NE(cut_twice.part[forearm].note.find("no wrist was found: this part may include some of the hand"),
            std::string::npos);
  EXPECT_EQ(cut_twice.part[hand].coverage, Coverage::absent);
}

}  // namespace
}  // namespace borelli::unparted_limbs_test
