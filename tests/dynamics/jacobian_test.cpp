// Jacobians and their biases against differences of positions and velocities, and against MuJoCo.
#include "dynamics/equations/jacobian.hpp"

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "random_scene.hpp"

#ifdef BORELLI_MUJOCO
#include "mujoco_twin.hpp"
#endif

namespace borelli::test::jacobian_test {
namespace {

// of central differences with step h: h^2 times third derivatives (about 100), and rounding / h
constexpr double h = 1e-5, tolerance = 1e-7;

State moved(const System& system, State state, const Eigen::VectorXd& x, double later = 0) {
  const Eigen::VectorXd q = state.q;
  from_local_coordinates(system, q.data(), x.data(), state.q.data());
  state.t += later;
  return state;
}

/// The scenes of the tests: trees of all joints, some driven.
template <class Test>
void for_each_scene(Test&& test) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const System system = compiled(random_tree(seed, {.balls = true, .drives = seed % 2 == 1}));
    State state = Random(seed + 40).state(system);
    state.t = 0.3;
    test(system, state);
  }
}

TEST(Jacobian, OfAPointMatchesDifferences) {
  for_each_scene([](const System& system, const State& state) {
    const SolidPoint at{"s4", {0.2, -0.3, 0.1}};
    const PointMotion now = need(point_motion(system, state, at));
    const auto place = [&](const State& other) { return need(point_motion(system, other, at)); };
    for (int i = 0; i < system.nv; ++i) {
      const Eigen::VectorXd x = h * Eigen::VectorXd::Unit(system.nv, i);
      const Vector3d slope =
          (place(moved(system, state, x)).position - place(moved(system, state, -x)).position) / (2 * h);
      EXPECT_LT((now.jacobian.col(i) - slope).norm(), tolerance);
      State faster = state;
      faster.v[i] += 1;  // velocities are linear in v
      EXPECT_LT((now.jacobian.col(i) - (place(faster).velocity - now.velocity)).norm(), 1e-12);
      EXPECT_LT(
          (now.angular_jacobian.col(i) - (place(faster).angular_velocity - now.angular_velocity)).norm(),
          1e-12);
    }
    const PointMotion ahead = place(moved(system, state, h * state.v, h)),
                      behind = place(moved(system, state, -h * state.v, -h));
    EXPECT_LT((now.velocity - (ahead.position - behind.position) / (2 * h)).norm(), tolerance);
    EXPECT_LT((now.bias - (ahead.velocity - behind.velocity) / (2 * h)).norm(), tolerance);
    EXPECT_LT((now.angular_bias - (ahead.angular_velocity - behind.angular_velocity) / (2 * h)).norm(),
              tolerance);
  });
}

TEST(Jacobian, OfTheMomentumGivesMomentumAndItsRate) {
  for_each_scene([](const System& system, const State& state) {
    const auto evaluated = [&](const State& at) { return need(evaluate(system, at)); };
    const Evaluation now = evaluated(state);
    State still = state;
    still.v.setZero();
    const Momenta drives = evaluated(still).momenta;  // momenta from the drives
    Eigen::Matrix<double, 6, 1> momentum;
    momentum << now.momenta.angular - drives.angular, now.momenta.linear - drives.linear;
    EXPECT_LT((now.centroidal.matrix * state.v - momentum).norm(), 1e-12 * (1 + momentum.norm()));
    const Momenta ahead = evaluated(moved(system, state, h * state.v, h)).momenta,
                  behind = evaluated(moved(system, state, -h * state.v, -h)).momenta;
    EXPECT_LT((now.centroidal.bias.head<3>() - (ahead.angular - behind.angular) / (2 * h)).norm(),
              10 * tolerance);
    EXPECT_LT((now.centroidal.bias.tail<3>() - (ahead.linear - behind.linear) / (2 * h)).norm(),
              10 * tolerance);
    EXPECT_LT((now.momenta.velocity - (ahead.centre - behind.centre) / (2 * h)).norm(), tolerance);
  });
}

// Euler's laws: weight alone changes the linear momentum of a free body, but not its angular momentum about
// the gravity centre.
TEST(Jacobian, MomentumChangesOnlyByWeight) {
  Scene scene;
  Random random(9);
  scene.solids = {solid("a", "world", free_switches("a"), {random.inertia().inertial()}),
                  solid("b", "a", {fixed(random.vector(0.5)), ball("joint")}, {random.inertia().inertial()})};
  const System system = compiled(scene);
  const State state = random.state(system);
  const Evaluation now = need(evaluate(system, state));
  const Eigen::Matrix<double, 6, 1> rate = now.centroidal.matrix * now.acceleration + now.centroidal.bias;
  EXPECT_LT(rate.head<3>().norm(), 1e-11);
  EXPECT_LT((rate.tail<3>() - now.momenta.mass * scene.gravity).norm(), 1e-11);
}

TEST(Jacobian, OfAMissingSolidIsRefused) {
  const System system = compiled(chain(2, false));
  EXPECT_EQ(point_motion(system, system.initial, {"none", {0, 0, 0}}).error().message(),
            "point of 'none': the scene has no solid of this name");
  EXPECT_FALSE(point_motion(system, system.initial, {"l0", {NAN, 0, 0}}));
  State wrong = system.initial;
  wrong.q.resize(1);
  EXPECT_FALSE(point_motion(system, wrong, {"l0", {0, 0, 0}}));
}

#ifdef BORELLI_MUJOCO
TEST(Jacobian, MatchesMuJoCo) {
  for (Joints joints : {Joints::hinges, Joints::balls, Joints::mixed, Joints::free}) {
    const Twin twin = TwinMaker(5, joints, 6).make();
    const System system = compiled(twin.scene);
    const Mujoco mujoco = Mujoco::of(twin.xml);
    const State state = Random(3).state(system);
    std::copy(state.q.begin(), state.q.end(), mujoco.data->qpos);
    std::copy(state.v.begin(), state.v.end(), mujoco.data->qvel);
    mj_forward(mujoco.model, mujoco.data);
    mj_subtreeVel(mujoco.model, mujoco.data);
    const int n = system.nv;
    const int body = mj_name2id(mujoco.model, mjOBJ_BODY, twin.scene.solids.back().name.c_str());
    ASSERT_GT(body, 0);
    const PointMotion now =
        need(point_motion(system, state, {twin.scene.solids.back().name, {0.1, 0.2, -0.3}}));
    RowsOf<double> linear = RowsOf<double>::Zero(3, n), angular = linear;
    mj_jac(mujoco.model, mujoco.data, linear.data(), angular.data(), now.position.data(), body);
    EXPECT_LT((now.jacobian - linear).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((now.angular_jacobian - angular).cwiseAbs().maxCoeff(), 1e-12);
    const Evaluation e = need(evaluate(system, state));
    EXPECT_LT((e.momenta.centre - Eigen::Map<Vector3d>(mujoco.data->subtree_com)).norm(), 1e-12);
    EXPECT_LT((e.momenta.velocity - Eigen::Map<Vector3d>(mujoco.data->subtree_linvel)).norm(), 1e-12);
    EXPECT_LT((e.momenta.angular - Eigen::Map<Vector3d>(mujoco.data->subtree_angmom)).norm(), 1e-11);
    mj_jacSubtreeCom(mujoco.model, mujoco.data, linear.data(), 0);
    EXPECT_LT((e.centroidal.matrix.bottomRows<3>() / e.momenta.mass - linear).cwiseAbs().maxCoeff(), 1e-12);
  }
}
#endif

}  // namespace
}  // namespace borelli::test::jacobian_test
