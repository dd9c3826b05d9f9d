// A, Q - B and accelerations against MuJoCo on random trees of hinges, slides, balls and free bodies: another
// program, by other equations. Built only where MuJoCo is installed.
#include <gtest/gtest.h>

#ifdef BORELLI_MUJOCO
#include "dynamics/evaluate.hpp"
#include "mujoco_twin.hpp"

namespace borelli::test {
namespace {

double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

void compare(Joints joints, int count, unsigned seed) {
  const Twin twin = TwinMaker(seed, joints, count).make();
  System system = compiled(twin.scene);
  Model mujoco(twin.xml);
  ASSERT_EQ(system.nq, mujoco.model->nq);
  ASSERT_EQ(system.nv, mujoco.model->nv);
  Random random(seed + 1000);
  for (int trial = 0; trial < 3; ++trial) {
    const State state = random.state(system);
    std::copy(state.q.begin(), state.q.end(), mujoco.data->qpos);
    std::copy(state.v.begin(), state.v.end(), mujoco.data->qvel);
    mj_forward(mujoco.model, mujoco.data);
    Rows A(system.nv, system.nv);
    mj_fullM(mujoco.model, A.data(), mujoco.data->qM);
    const Eigen::Map<Eigen::VectorXd> bias(mujoco.data->qfrc_bias, system.nv),
        a(mujoco.data->qacc, system.nv);
    for (Equations equations : {Equations::recursive, Equations::lagrange}) {
      system.settings.equations = equations;
      const Evaluation ours = need(evaluate(system, state));
      // both are exact but for rounding, which the condition of A (up to 1e5 here) carries into a
      EXPECT_LT(relative(ours.mass_matrix, A), 1e-12) << "seed " << seed;
      EXPECT_LT(relative(ours.generalized_efforts - ours.bias, -bias), 1e-12) << "seed " << seed;
      EXPECT_LT(relative(ours.acceleration, a), 1e-9) << "seed " << seed;
    }
  }
}

TEST(MuJoCo, AgreesOnHinges) {
  for (unsigned seed = 0; seed < 10; ++seed) compare(Joints::hinges, 8, seed);
}
TEST(MuJoCo, AgreesOnBalls) {
  for (unsigned seed = 0; seed < 10; ++seed) compare(Joints::balls, 8, seed);
}
TEST(MuJoCo, AgreesOnMixedJointsSeveralToASolid) {
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
TEST(MuJoCo, Agrees) { GTEST_SKIP() << "MuJoCo (libmujoco-dev) was not there at configuration"; }
#endif
