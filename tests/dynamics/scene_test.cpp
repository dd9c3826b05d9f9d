// The sources of a solid's inertia.
#include "dynamics/scene/scene.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

TEST(Scene, ShapesAddToGivenInertials) {
  Solid solid;
  solid.name = "block";
  solid.inertials = {{1, {0, 0, 1}, Eigen::Matrix3d::Identity()}};
  solid.shapes = {{{Box{{1, 1, 1}}}, 3, {}}, {{Sphere{1}}, {}, {}}, {{Box{{1, 1, 1}}}, {}, 6}};
  const auto found = inertials_of(solid);
  ASSERT_TRUE(found) << found.error().message();
  ASSERT_EQ(found->size(), 3u);  // the sphere is only visual
  EXPECT_DOUBLE_EQ((*found)[0].mass, 1);
  EXPECT_DOUBLE_EQ((*found)[1].mass, 3);
  EXPECT_DOUBLE_EQ((*found)[1].tensor(0, 0), 0.5);  // m (1 + 1) / 12
  EXPECT_DOUBLE_EQ((*found)[2].tensor(2, 2), 1);
}

TEST(Scene, BadShapesAreNamedWithTheirSolid) {
  Solid solid;
  solid.name = "block";
  solid.shapes = {{{Box{{1, 1, 1}}}, 3, {}}, {{Sphere{-1}}, 1, {}}};
  EXPECT_EQ(inertials_of(solid).error().message(),
            "solid 'block', shape 2: sphere: radius is -1, expected a positive number of metres");
  solid.shapes[1] = {{Sphere{1}}, 1, 1};
  EXPECT_NE(inertials_of(solid).error().message().find("a density and a mass"), std::string::npos);
}

TEST(Scene, UnnamedCoordinatesHaveTheirSolidsName) {
  Solid solid;
  solid.name = "leg";
  solid.switches = {{Fixed{}}, {Rotation{}}};
  EXPECT_EQ(coordinate_name(solid, 0), "");
  EXPECT_EQ(coordinate_name(solid, 1), "leg");
  solid.switches = {{Translation{}}, {Fixed{}}, {Rotation{}, "knee"}, {Ball{}}};
  EXPECT_EQ(coordinate_name(solid, 0), "leg.1");
  EXPECT_EQ(coordinate_name(solid, 2), "knee");
  EXPECT_EQ(coordinate_name(solid, 3), "leg.3");
}

}  // namespace
}  // namespace borelli
