// The usual place of the wrist on an arm's path.
#include "segmentation/joints/joints_along_path.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

using Eigen::Vector3d;

// upper arm down, forearm and hand to the front
LimbPath bent_arm(double upper_arm, double beyond) {
  LimbPath path;
  path.present = true;
  for (double s = 0; s < upper_arm + beyond + 0.5 * LimbPath::spacing; s += LimbPath::spacing)
    path.points.push_back(s < upper_arm ? Vector3d(0, 0, -s) : Vector3d(0, upper_arm - s, -upper_arm));
  return path;
}

TEST(JointsAlongPath, UsualWristIsThreeFifthsFromTheElbowToTheEnd) {
  const auto wrist = usual_wrist(bent_arm(300, 450), Vector3d(2, 1, -298));
  ASSERT_TRUE(wrist);
  EXPECT_NEAR(wrist->length, 450, LimbPath::spacing);
  EXPECT_LT((wrist->point - Vector3d(0, -0.6 * 450, -300)).norm(), 1.5 * LimbPath::spacing);
  EXPECT_FALSE(usual_wrist(bent_arm(300, 150), Vector3d(0, 0, -300))) << "an arm that ends below the elbow";
}

}  // namespace
}  // namespace borelli
