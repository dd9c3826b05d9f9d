#include <gtest/gtest.h>

#include "segmentation/proposal/limb_joints.hpp"
#include "tests/segmentation/proposal/certain.hpp"
#include "tests/segmentation/proposal/drawn_body.hpp"

namespace borelli::proposal_test {
namespace {

TEST(LimbSegments, PutJointsAtChangesOfProbability) {
  const CoarseBody body = coarse_body(anatomy_of(drawn().grey, 4, 0));
  const auto probabilities = certain(body, drawn().parts);
  const auto forest = ready_forest();
  ASSERT_TRUE(forest);
  PhantomOptions options;
  options.stature_m = 1.3;
  const auto exact = build_phantom(options);
  const auto segments = limb_segments(body, probabilities, body_pieces(body, probabilities), *forest);
  EXPECT_EQ(segments.joints.size(), 8U);
  // two voxels along the limb, because distances bend near the skin; the bone's middle stands for the joint
  for (const ProposedJoint& joint : segments.joints)
    EXPECT_LT((joint.point - exact->landmarks.at(joint.name).point).norm(), 20) << joint.name;
}

}  // namespace
}  // namespace borelli::proposal_test
