// Limbs followed along their bones from hips and shoulders.
#include "segmentation/joints/limbs.hpp"

#include <gtest/gtest.h>

#include "tests/segmentation/proposal/drawn_body.hpp"

namespace borelli {
namespace {

// A body that bends sideways has a tilted pelvis. The strip between its hips, extended upwards along the
// tilt, reaches a shoulder.
TEST(Limbs, TiltedPelvisLeavesTheArmsTheirBones) {
  const Anatomy a = anatomy_of(proposal_test::drawn().grey, 4, 0);
  Trunk trunk = find_trunk(a);
  ASSERT_TRUE(trunk.hip[0] && trunk.hip[1] && trunk.shoulder[0] && trunk.shoulder[1]);
  const Limbs level = trace_limbs(a, trunk);
  constexpr double tilt = 15;  // mm at each hip: 10 degrees
  trunk.hip[left_side]->centre[2] -= tilt, trunk.hip[right_side]->centre[2] += tilt;
  const Limbs tilted = trace_limbs(a, trunk);
  for (const int side : {left_side, right_side}) {
    EXPECT_GT(level.arm(side).length(), 500);
    // the paths may begin elsewhere in the head, whose core is 30 mm wide
    EXPECT_NEAR(tilted.arm(side).length(), level.arm(side).length(), 20) << side_suffix(side);
  }
}

}  // namespace
}  // namespace borelli
