// A, Q - B and accelerations against MuJoCo on random trees of hinges, slides, balls and free bodies. Needs
// MuJoCo.
#include <gtest/gtest.h>

#ifdef BORELLI_MUJOCO
#include "mujoco_twin.hpp"

namespace borelli::test {
namespace {

void compare(Joints joints, int count, unsigned seed) {
  const Twin twin = TwinMaker(seed, joints, count).make();
  System system = compiled(twin.scene);
  Mujoco mujoco = Mujoco::of(twin.xml);
  for (Equations equations : {Equations::recursive, Equations::lagrange}) {
    system.settings.equations = equations;
    const Differences found = differences(system, mujoco, seed + 1000);
    // both are exact but for rounding, which the condition of A (up to 1e5 here) carries into a
    EXPECT_LT(found.A, 1e-12) << "seed " << seed;
    EXPECT_LT(found.drive, 1e-12) << "seed " << seed;
    EXPECT_LT(found.acceleration, 1e-9) << "seed " << seed;
  }
}

TEST(MuJoCo, AgreesOnHinges) {
  for (unsigned seed = 0; seed < 10; ++seed) compare(Joints::hinges, 8, seed);
}
TEST(MuJoCo, AgreesOnBalls) {
  for (unsigned seed = 0; seed < 10; ++seed) compare(Joints::balls, 8, seed);
}
TEST(MuJoCo, AgreesOnSeveralMixedJointsPerSolid) {
  for (unsigned seed = 0; seed < 10; ++seed) compare(Joints::mixed, 10, seed);
}
TEST(MuJoCo, AgreesOnTreesWithAFreeRoot) {
  for (unsigned seed = 0; seed < 10; ++seed) compare(Joints::free, 10, seed);
}
TEST(MuJoCo, AgreesOnAFreeSolid) {
  for (unsigned seed = 0; seed < 10; ++seed) compare(Joints::free, 1, seed);
}

}  // namespace
}  // namespace borelli::test

#else
TEST(MuJoCo, AgreesOnAllModels) { GTEST_SKIP() << "MuJoCo (libmujoco-dev) was not there at configuration"; }
#endif
