// Borders between labels: continuous flesh, or skin that touches skin.
#include "pipeline/export/skin_contacts.hpp"

#include <gtest/gtest.h>

namespace borelli::test::skin_contacts_test {
namespace {

using Eigen::Vector3d;

/// A block with two columns on it, side by side: parts 0, 1 and 2 on a grid of 2 mm; 1 is the larger column.
/// Each column has a joint with the block, where its part's axis points up.
struct Columns {
  Volume<std::uint8_t> body;
  std::vector<SkinPart> parts{3};

  Columns() {
    body.grid.size = {45, 20, 60};
    body.grid.axes *= 2;
    body.voxels.resize(body.grid.count());
    for (std::int64_t k = 0; k < 60; ++k)
      for (std::int64_t j = 0; j < 20; ++j)
        for (std::int64_t i = 0; i < 45; ++i) body.at(i, j, k) = k < 20 ? 1 : i < 25 ? 2 : 3;
    for (std::size_t n : {1u, 2u}) {
      parts[n].parent = 0;
      parts[n].has_joint = true;
      parts[n].half_thickness = 0.02;
      parts[n].centre = {n == 1 ? 0.02 : 0.07, 0.02, 0.04};
    }
  }
};

TEST(FleshJoins, APartToItsParentNearTheirJoint) {
  const Columns c;
  const Vector3d joint = c.parts[1].centre;
  EXPECT_TRUE(flesh_joins(c.parts, 0, 1, joint));
  EXPECT_TRUE(flesh_joins(c.parts, 1, 0, joint + Vector3d(0.07, 0, -0.01)));
  EXPECT_FALSE(flesh_joins(c.parts, 0, 1, joint + Vector3d(0.09, 0, 0)));   // more than four half thicknesses
  EXPECT_FALSE(flesh_joins(c.parts, 0, 1, joint + Vector3d(0, 0, 0.045)));  // more than two along the part
  EXPECT_FALSE(flesh_joins(c.parts, 1, 2, joint));
}

// The columns' border lies between i = 24 and 25. Up to 10 mm above the block three cuts meet.
TEST(OpenContacts, SeparateColumnsAboveTheBlock) {
  Columns c;
  const auto before = c.body.voxels;
  open_contacts(c.body, c.parts);
  std::size_t closed = 0;
  for (std::size_t n = 0; n < before.size(); ++n) closed += before[n] != c.body.voxels[n];
  // layers 20 to 24 are within five voxels of the block's last one, 19
  for (std::int64_t k = 0; k < 60; ++k) EXPECT_EQ(c.body.at(24, 7, k) == 0, k >= 25) << k;
  EXPECT_EQ(closed, 35u * 20u);  // one voxel thick, taken from the larger column
}

}  // namespace
}  // namespace borelli::test::skin_contacts_test
