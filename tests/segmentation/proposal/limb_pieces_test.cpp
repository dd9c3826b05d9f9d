#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "segmentation/proposal/limb_pieces.hpp"
#include "tests/segmentation/proposal/certain.hpp"
#include "tests/segmentation/proposal/drawn_body.hpp"

namespace borelli::proposal_test {
namespace {

TEST(LimbPieces, FindTwoArmsAndTwoLegsWithTheirSides) {
  const CoarseBody body = coarse_body(anatomy_of(drawn().grey, 4, 0));
  const BodyPieces pieces = body_pieces(body, certain(body, drawn().parts));
  std::map<std::pair<BodyRegion, int>, int> count;
  for (const BodyPiece& piece : pieces.list) {
    ++count[{piece.region, piece.side}];
    if (!is_limb(piece.region)) continue;
    EXPECT_GT(piece.bone_chain, 300);
    ASSERT_TRUE(piece.root);
    EXPECT_EQ(piece.side == left_side, (*piece.root)[0] > 0);  // the phantom is centred on x = 0
    EXPECT_FALSE(piece.cut);
  }
  const std::map<std::pair<BodyRegion, int>, int> expected{
      {{BodyRegion::head, -1}, 1},       {{BodyRegion::trunk, -1}, 1},
      {{BodyRegion::arm, left_side}, 1}, {{BodyRegion::arm, right_side}, 1},
      {{BodyRegion::leg, left_side}, 1}, {{BodyRegion::leg, right_side}, 1}};
  EXPECT_EQ(count, expected);
}

TEST(LimbPieces, NeedBones) {
  CoarseBody body = coarse_body(anatomy_of(drawn().grey, 4, 0));
  const auto probabilities = certain(body, drawn().parts);
  for (std::size_t n = 0; n < body.places.size(); ++n)
    if (probabilities.of(n)[5] || probabilities.of(n)[6] || probabilities.of(n)[7])
      body.bone.voxels[body.places[n]] = 0, body.off_bone[body.places[n]] = 60;
  for (const BodyPiece& piece : body_pieces(body, probabilities).list)
    EXPECT_NE(piece.region, BodyRegion::leg);
}

}  // namespace
}  // namespace borelli::proposal_test
