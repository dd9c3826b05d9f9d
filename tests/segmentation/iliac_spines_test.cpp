// The anterior superior iliac spines.
#include "segmentation/joints/iliac_spines.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/segmentation/proposal/drawn_body.hpp"

namespace borelli::iliac_spines_test {
namespace {

using Eigen::Vector3d;

Landmarks spines_in(const Anatomy& a) {
  const Trunk trunk = find_trunk(a);
  Landmarks marks;
  find_iliac_spines(a, trunk, trace_limbs(a, trunk), marks);
  return marks;
}

// A vessel with contrast runs forwards from the bone beside each hip, medial of it, and ends in front of the spines.
TEST(IliacSpines, LieLateralOfTheHips) {
  GreyVolume grey = proposal_test::drawn().grey;
  const Anatomy plain = anatomy_of(grey, 4, 0);
  const Trunk trunk = find_trunk(plain);
  const Landmarks exact = spines_in(plain);
  ASSERT_TRUE(exact.contains("asis_left") && exact.contains("asis_right"));
  const Grid& g = grey.grid;
  for (const int side : {left_side, right_side}) {
    const Vector3d hip = trunk.hip[static_cast<std::size_t>(side)]->centre,
                   spine = exact.at(std::string("asis") + side_suffix(side)).point;
    const Vector3d at = g.index(Vector3d(hip[0] - side_sign(side) * 12, 0, hip[2] + 55 * trunk.scale));
    const auto i = std::lround(at[0]), k = std::lround(at[2]), front = std::lround(g.index(spine)[1]) - 4;
    auto back = front;
    while (grey.at(i, back, k) < 200) ASSERT_LT(++back, g.size[1] - 1);
    for (auto j = front; j <= back; ++j)
      for (const int up : {0, 1}) grey.at(i, j, k + up) = 500;
  }
  const Landmarks found = spines_in(anatomy_of(grey, 4, 0));
  for (const char* name : {"asis_left", "asis_right"})
    EXPECT_LT((found.at(name).point - exact.at(name).point).norm(), 4) << name;
}

}  // namespace
}  // namespace borelli::iliac_spines_test
