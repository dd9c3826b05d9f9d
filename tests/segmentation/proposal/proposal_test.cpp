#include "segmentation/proposal/proposal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "segmentation/labelling/second_opinion.hpp"
#include "segmentation/proposal/limb_roots.hpp"
#include "segmentation/proposal/walls.hpp"
#include "tests/segmentation/proposal/certain.hpp"
#include "tests/segmentation/proposal/drawn_body.hpp"

namespace borelli::proposal_test {
namespace {

struct Proposed {
  Anatomy anatomy;
  LabelMap exact;
};

// the drawn body with a proposal that is certain and correct
Proposed proposed() {
  Proposed out{anatomy_of(drawn().grey, 4, 0), drawn().parts};
  const CoarseBody body = coarse_body(out.anatomy);
  const auto forest = ready_forest();
  out.anatomy.proposal =
      std::make_shared<const Proposal>(proposal_of(body, certain(body, out.exact), *forest));
  return out;
}

Segmentation segmentation_of(const LabelMap& labels) {
  Segmentation out;
  out.labels = labels;
  for (const std::uint8_t label : labels.voxels) {
    out.part[label].coverage = Coverage::whole;
    out.part[label].confidence = 1;
    out.part[label].volume += labels.grid.voxel_volume();
  }
  return out;
}

TEST(Proposal, RecognisesEachLimbAndSide) {
  const Proposed body = proposed();
  const Proposal& proposal = *body.anatomy.proposal;
  const std::vector<std::uint8_t> limbs = sure_limbs(proposal, body.exact.grid, 0);
  double sure = 0, right = 0, all = 0;
  for (std::size_t o = 0; o < limbs.size(); ++o) {
    if (!body.exact.voxels[o]) continue;
    ++all, sure += limbs[o] != 0;
    right += limbs[o] == limb_of_part(body.exact.voxels[o]);
  }
  EXPECT_GT(sure / all, 0.85);  // lower near another region, since a voxel's share is its neighbours' mean
  EXPECT_GT(right / sure, 0.98);
}

TEST(LimbRoots, LieAtTheHeads) {
  const Proposed body = proposed();
  PhantomOptions options;
  options.stature_m = 1.3;
  const auto exact = build_phantom(options);
  ASSERT_TRUE(exact);
  for (const auto& [region, name] : {std::pair(BodyRegion::leg, std::string("hip")),
                                     std::pair(BodyRegion::arm, std::string("shoulder"))}) {
    const LimbRoots roots(body.anatomy, region);
    for (const int side : {left_side, right_side}) {
      const auto& joint = roots.joint[static_cast<std::size_t>(side)];
      ASSERT_TRUE(joint) << name << side_suffix(side);
      EXPECT_LT((*joint - exact->landmarks.at(name + side_suffix(side)).point).norm(), 40)
          << name << side_suffix(side);
    }
    EXPECT_TRUE(roots.sure());
    const auto &left = *roots.joint[0], &right = *roots.joint[1];
    EXPECT_EQ(roots.likelihood(left, right), 1);
    EXPECT_EQ(roots.likelihood(left + Eigen::Vector3d(0, 0, 50), right), 1);
    EXPECT_LT(roots.likelihood(left + Eigen::Vector3d(0, 0, 90), right), 0.5);
    EXPECT_EQ(roots.likelihood(left + Eigen::Vector3d(0, 0, 200), right), 0);
  }
  Anatomy unasked = body.anatomy;
  unasked.proposal = nullptr;
  EXPECT_FALSE(LimbRoots(unasked, BodyRegion::leg).sure());
  EXPECT_EQ(LimbRoots(unasked, BodyRegion::leg).likelihood({0, 0, 0}, {500, 0, 0}), 1);
}

// A joint 200 mm off is doubted, except in a limb that lacks a segment.
TEST(SecondOpinion, DoubtsOnlyJointsOfWholeLimbs) {
  const Proposed body = proposed();
  const auto knee = std::find_if(body.anatomy.proposal->joints.begin(), body.anatomy.proposal->joints.end(),
                                 [](const ProposedJoint& joint) { return joint.name == "knee_left"; });
  ASSERT_NE(knee, body.anatomy.proposal->joints.end());
  const auto deviation_at = [&](double off, const AbsentParts& absent) {
    Landmarks landmarks;
    landmarks["knee_left"] = {knee->point + Eigen::Vector3d(0, 0, off), 3};
    doubt_joints_by_proposal(body.anatomy, absent, landmarks);
    return landmarks.at("knee_left").deviation;
  };
  EXPECT_EQ(deviation_at(20, {}), 3);
  EXPECT_DOUBLE_EQ(deviation_at(200, {}), 100);
  AbsentParts without_foot{}, without_hand{};
  without_foot[static_cast<std::size_t>(part_label("foot_left"))] = true;
  without_hand[static_cast<std::size_t>(part_label("hand_left"))] = true;
  EXPECT_EQ(deviation_at(200, without_foot), 3);
  EXPECT_DOUBLE_EQ(deviation_at(200, without_hand), 100);
}

TEST(SecondOpinion, AcceptsCorrectParts) {
  const Proposed body = proposed();
  Segmentation parted = segmentation_of(body.exact);
  doubt_by_proposal(*body.anatomy.proposal, parted);
  EXPECT_TRUE(parted.warnings.empty());
  for (std::size_t n = 1; n < parts.size(); ++n) EXPECT_EQ(parted.part[n].confidence, 1) << parts[n].name;
}

TEST(SecondOpinion, NamesALimbLabelledAsItsNeighbour) {
  const Proposed body = proposed();
  LabelMap labels = body.exact;
  for (const char* part : {"upper_arm_right", "forearm_right", "hand_right"})
    std::replace(labels.voxels.begin(), labels.voxels.end(), static_cast<std::uint8_t>(part_label(part)),
                 static_cast<std::uint8_t>(part_label("middle_trunk")));
  Segmentation parted = segmentation_of(labels);
  doubt_by_proposal(*body.anatomy.proposal, parted);
  ASSERT_EQ(parted.warnings.size(), 1U);
  EXPECT_EQ(parted.warnings[0].severity, Severity::doubt);
  EXPECT_NE(parted.warnings[0].text.find("right arm"), std::string::npos) << parted.warnings[0].text;
  const PartFinding& trunk = parted.part[static_cast<std::size_t>(part_label("middle_trunk"))];
  EXPECT_LT(trunk.confidence, 0.5);
  EXPECT_NE(trunk.note.find("right arm"), std::string::npos) << trunk.note;
}

// two seeds at the ends of a bar: a wall beside its middle moves the border there
TEST(Walls, KeepPathsOutOfAnotherLimb) {
  Anatomy a;
  a.scan.hu.grid.size = {20, 1, 1};
  const Grid& g = a.grid();
  Volume<std::uint8_t> seeds{g, std::vector<std::uint8_t>(20)};
  const auto thigh = static_cast<std::uint8_t>(part_label("thigh_left")),
             hand = static_cast<std::uint8_t>(part_label("hand_left"));
  seeds.voxels[0] = thigh, seeds.voxels[19] = hand;
  const auto owners = [&] {
    return nearest_seeds(walled(a, Places(g, 1, [](std::size_t) { return 1.0F; }), kind_of_part), seeds);
  };
  const auto plain = owners();
  EXPECT_EQ(plain.voxels[5], thigh);
  EXPECT_EQ(plain.voxels[15], hand);
  a.wall.assign(20, 0);
  for (std::size_t n = 5; n < 20; ++n) a.wall[n] = wall_kind(limb_of_part(hand));
  const auto with_wall = owners();
  for (std::size_t n = 0; n < 20; ++n) EXPECT_EQ(with_wall.voxels[n], n < 5 ? thigh : hand) << n;
}

TEST(SecondOpinion, ReportsHeadsInAnotherLimb) {
  const Proposed body = proposed();
  const LimbRoots legs(body.anatomy, BodyRegion::leg);
  ASSERT_TRUE(legs.sure());
  Trunk trunk;
  for (const std::size_t side : {0, 1}) trunk.hip[side] = FoundSphere{*legs.joint[side]};
  EXPECT_TRUE(heads_agree(*body.anatomy.proposal, trunk));
  trunk.hip[0]->centre = *legs.joint[1] - Eigen::Vector3d(0, 0, 150);  // within the other thigh
  EXPECT_FALSE(heads_agree(*body.anatomy.proposal, trunk));
  trunk.no_leg[0] = true;
  EXPECT_TRUE(heads_agree(*body.anatomy.proposal, trunk));
}

// two adjacent arms and a separate leg
TEST(Walls, LetTouchingSidesPass) {
  Proposal proposal;
  proposal.grid.size = {6, 1, 1};
  const auto left = static_cast<std::uint8_t>(limb_of(BodyRegion::arm, left_side)),
             right = static_cast<std::uint8_t>(limb_of(BodyRegion::arm, right_side)),
             leg = static_cast<std::uint8_t>(limb_of(BodyRegion::leg, left_side));
  proposal.limb = {left, 0, right, 0, leg, 0};
  EXPECT_EQ(kinds_let_in(proposal)[left], wall_kind(left));
  proposal.limb = {0, left, right, 0, leg, 0};
  EXPECT_EQ(kinds_let_in(proposal)[left], wall_kind(left) | wall_kind(right));
  EXPECT_EQ(kinds_let_in(proposal)[right], wall_kind(left) | wall_kind(right));
  EXPECT_EQ(kinds_let_in(proposal)[leg], wall_kind(leg));
}

}  // namespace
}  // namespace borelli::proposal_test
