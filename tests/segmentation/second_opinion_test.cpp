// Joints that disagree with the forest's.
#include "segmentation/labelling/second_opinion.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace borelli {
namespace {

using Eigen::Vector3d;

double deviation_beside(const std::vector<Vector3d>& proposed) {
  Proposal proposal;
  for (const Vector3d& point : proposed)
    proposal.joints.push_back({0, BodyRegion::leg, left_side, "knee_left", point, 20});
  Anatomy a;
  a.proposal = std::make_shared<const Proposal>(std::move(proposal));
  Landmarks marks{{"knee_left", {Vector3d(100, 0, 450), 4, 0, "bone"}}};
  doubt_joints_by_proposal(a, {}, marks);
  return marks.at("knee_left").deviation;
}

TEST(SecondOpinion, NearestPieceOfALimbJudgesItsJoint) {
  const Vector3d near(110, 5, 440), far(-300, 0, 1200);
  EXPECT_EQ(deviation_beside({near}), 4);
  EXPECT_EQ(deviation_beside({far, near}), 4) << "another piece that was taken for the same leg";
  EXPECT_NEAR(deviation_beside({Vector3d(100, 0, 650)}), 100, 1e-9) << "half of the distance";
}

}  // namespace
}  // namespace borelli
