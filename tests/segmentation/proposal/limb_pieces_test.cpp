#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "segmentation/proposal/limb_pieces.hpp"
#include "segmentation/proposal/proposal.hpp"
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

// Whatever of an arm lies near the trunk is taken for a leg.
TEST(LimbPieces, WholeLimbSeparatedFromTheTrunkGetsItsSide) {
  const CoarseBody body = coarse_body(anatomy_of(drawn().grey, 4, 0));
  LabelMap labels = drawn().parts;
  const Grid& g = labels.grid;
  constexpr std::int64_t near = 5;  // voxels of 4 mm
  const auto beside_trunk = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    for (std::int64_t c = -near; c <= near; ++c)
      for (std::int64_t b = -near; b <= near; ++b)
        for (std::int64_t a = -near; a <= near; ++a)
          if (g.holds(i + a, j + b, k + c) && is_axial(drawn().parts.at(i + a, j + b, k + c))) return true;
    return false;
  };
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        if (limb_of_part(labels.at(i, j, k)) == limb_of(BodyRegion::arm, left_side) && beside_trunk(i, j, k))
          labels.at(i, j, k) = static_cast<std::uint8_t>(part_label("thigh_left"));
  const BodyPieces pieces = body_pieces(body, certain(body, labels));
  int arms = 0;
  for (const BodyPiece& piece : pieces.list) {
    if (piece.region != BodyRegion::arm) continue;
    ++arms;
    ASSERT_TRUE(piece.root);
    EXPECT_EQ(piece.side, (*piece.root)[0] > 0 ? left_side : right_side);
  }
  EXPECT_EQ(arms, 2);
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
