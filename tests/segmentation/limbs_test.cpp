// Limbs followed along their bones from hips and shoulders.
#include "segmentation/joints/limbs.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

// Calcium, contrast and noise in the flesh look like bone. A bit of it beside the femur is farther from the
// hip, by the cost of that gap, than the toes are.
TEST(Limbs, BitsOfBoneInTheFleshAreNoEndOfALimb) {
  GreyVolume grey = proposal_test::drawn().grey;
  const Anatomy plain = anatomy_of(grey, 4, 0);
  const Trunk trunk = find_trunk(plain);
  const LimbPath leg = trace_limbs(plain, trunk).leg(left_side);
  ASSERT_TRUE(leg.present);
  const Eigen::Vector3d bit = leg.points[leg.index(150)] + Eigen::Vector3d(31, 0, 0);
  const Eigen::Vector3d at = grey.grid.index(bit);
  for (const int k : {-1, 0, 1})
    for (const int j : {-1, 0, 1})
      for (const int i : {-1, 0, 1})
        grey.at(std::lround(at[0]) + i, std::lround(at[1]) + j, std::lround(at[2]) + k) = 800;
  const Anatomy specked = anatomy_of(grey, 4, 0);
  const Limbs found = trace_limbs(specked, trunk);
  const Eigen::Vector3d place = specked.grid().index(bit);
  const auto o = specked.grid().offset(std::lround(place[0]), std::lround(place[1]), std::lround(place[2]));
  ASSERT_TRUE(specked.bone.voxels[o]);
  ASSERT_EQ(found.territory.owner.voxels[o], static_cast<std::uint8_t>(Limb::leg_left));
  ASSERT_GT(found.territory.length(o), leg.length());
  EXPECT_NEAR(found.leg(left_side).length(), leg.length(), LimbPath::spacing);
}

}  // namespace
}  // namespace borelli
