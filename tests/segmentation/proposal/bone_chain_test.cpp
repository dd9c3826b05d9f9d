#include <gtest/gtest.h>

#include "segmentation/proposal/bone_chain.hpp"

namespace borelli::proposal_test {
namespace {

TEST(BoneChain, CrossesOnlyGapsOfJoints) {
  const Grid grid{{30, 30, 120}, 4 * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  Mask piece{grid, std::vector<std::uint8_t>(grid.count(), 1)},
      bone{grid, std::vector<std::uint8_t>(grid.count(), 0)};
  const auto put = [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k <= last; ++k)
      for (std::int64_t j = 14; j <= 16; ++j)
        for (std::int64_t i = 14; i <= 16; ++i) bone.at(i, j, k) = 1;
  };
  put(10, 40);
  const double one = bone_chain_length(piece, bone, 1);
  EXPECT_NEAR(one, 30 * 4, 8);  // its diagonal is a little longer
  put(44, 70);                  // 12 mm of flesh between them
  EXPECT_NEAR(bone_chain_length(piece, bone, 1), 60 * 4, 8);
  put(80, 110);  // 36 mm
  EXPECT_NEAR(bone_chain_length(piece, bone, 1), 60 * 4, 8);
  EXPECT_EQ(bone_chain_length(piece, {grid, std::vector<std::uint8_t>(grid.count(), 0)}, 1), 0);
}

}  // namespace
}  // namespace borelli::proposal_test
