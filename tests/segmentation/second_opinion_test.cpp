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

TEST(SecondOpinion, DoubtsTheEpicondylesWithTheirJoint) {
  Proposal proposal;
  proposal.joints.push_back({0, BodyRegion::leg, left_side, "knee_left", Vector3d(100, 0, 650), 20});
  Anatomy a;
  a.proposal = std::make_shared<const Proposal>(std::move(proposal));
  Landmarks marks{{"knee_left", {Vector3d(100, 0, 450), 4, 0, "bone"}},
                  {"knee_medial_left", {Vector3d(60, 0, 450), 6, 0, "bone"}},
                  {"knee_lateral_left", {Vector3d(140, 0, 450), 6, 0, "bone"}},
                  {"knee_medial_right", {Vector3d(-60, 0, 450), 6, 0, "bone"}}};
  doubt_joints_by_proposal(a, {}, marks);
  EXPECT_NEAR(marks.at("knee_medial_left").deviation, 100, 1e-9);
  EXPECT_NEAR(marks.at("knee_lateral_left").deviation, 100, 1e-9);
  EXPECT_EQ(marks.at("knee_medial_right").deviation, 6);
}

}  // namespace
}  // namespace borelli
