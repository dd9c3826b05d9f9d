// What lies about hips and what does not.
#include "segmentation/joints/heads_in_body.hpp"

#include <gtest/gtest.h>

#include "segmentation/joints/trunk.hpp"
#include "tests/segmentation/proposal/drawn_body.hpp"

namespace borelli::heads_in_body_test {
namespace {

using Eigen::Vector3d;

// The phantom with flesh in place of all bone between two heights over the hips (mm).
GreyVolume without_bone(const Vector3d& left, const Vector3d& right, double from, double to) {
  GreyVolume grey = proposal_test::drawn().grey;
  const Vector3d middle = 0.5 * (left + right);
  for (std::int64_t k = 0; k < grey.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grey.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grey.grid.size[0]; ++i)
        if (const double above = (grey.grid.point(i, j, k) - middle)[2];
            above > from && above < to && grey.at(i, j, k) > 100)
          grey.at(i, j, k) = 40;
  return grey;
}

TEST(HeadsInBody, HipsLieBelowSacrumOrLumbarVertebrae) {
  const Anatomy whole = anatomy_of(proposal_test::drawn().grey, 4, 0);
  const Trunk trunk = find_trunk(whole);
  ASSERT_TRUE(trunk.hip[0] && trunk.hip[1]);
  const Vector3d left = trunk.hip[0]->centre, right = trunk.hip[1]->centre;
  EXPECT_TRUE(HeadsInBody(whole).near_hips(left, right));
  // the ICRP female's sacrum is no denser than flesh
  const GreyVolume no_sacrum = without_bone(left, right, 30, 115);
  EXPECT_TRUE(HeadsInBody(anatomy_of(no_sacrum, 4, 0)).near_hips(left, right));
  const GreyVolume no_column = without_bone(left, right, 30, 250);
  EXPECT_FALSE(HeadsInBody(anatomy_of(no_column, 4, 0)).near_hips(left, right));
}

}  // namespace
}  // namespace borelli::heads_in_body_test
