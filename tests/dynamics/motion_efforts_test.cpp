// Inverse dynamics under measured forces, against the scene's own forces and against forward dynamics.
#include "dynamics/inverse/motion_efforts.hpp"

#include "allocation_count.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "random_scene.hpp"

namespace borelli::test::motion_efforts_test {
namespace {

TEST(MotionEfforts, AddedToTheSceneGiveTheAccelerations) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const System system = compiled(random_tree(seed, {.balls = true, .drives = seed % 2 == 1}));
    Random random(seed + 70);
    const State state = random.state(system);
    const Eigen::VectorXd a = Eigen::VectorXd::NullaryExpr(system.nv, [&] { return random.number(-3, 3); });
    MotionEfforts efforts(system);
    const Eigen::VectorXd tau = efforts.needed(state, a, {});
    const Evaluation forward = need(evaluate(system, state, tau));
    EXPECT_LT((forward.acceleration - a).norm(), 1e-9 * (1 + a.norm() + tau.norm()));
  }
}

TEST(MotionEfforts, WrenchesActLikeForcesOfTheScene) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    Scene scene = random_tree(seed, {.balls = true, .drives = seed % 2 == 1});
    const System without = compiled(scene);
    Random random(seed + 90);
    const State state = random.state(without);
    const Eigen::VectorXd a = Eigen::VectorXd::NullaryExpr(without.nv, [&] { return random.number(-3, 3); });
    const Vector3d at = random.vector(0.3), force = random.vector(10), moment = random.vector(5);
    const int index =
        int(std::find(without.solids.begin(), without.solids.end(), "s3") - without.solids.begin());
    const Vector3d point = need(point_motion(without, state, {"s3", at})).position;
    MotionEfforts efforts(without);
    const Eigen::VectorXd measured = efforts.needed(state, a, {{index, force, point, moment}});

    scene.efforts.push_back({"push", Force{.at = {"s3", at}, .force = force}});
    scene.efforts.push_back({"turn", Torque{.on = {"s3"}, .torque = moment}});
    const System with = compiled(scene);
    MotionEfforts own(with);
    EXPECT_LT((measured - own.needed(state, a, {})).norm(), 1e-11 * (1 + measured.norm()));
  }
}

TEST(MotionEfforts, AllocateNothingAfterConstruction) {
#ifdef BORELLI_COUNTS_ALLOCATIONS
  const System system = compiled(random_tree(1, {.balls = true, .drives = true}));
  ASSERT_GT(system.size(), system.nv);
  Random random(71);
  const State state = random.state(system);
  const Eigen::VectorXd a = Eigen::VectorXd::Zero(system.nv);
  const std::vector<SolidWrench> push{{1, {1, 2, 3}, {0.1, 0.2, 0.3}, {3, 2, 1}}};
  MotionEfforts efforts(system);
  const long before = allocation_count;
  for (int i = 0; i < 3; ++i) efforts.needed(state, a, push);
  EXPECT_EQ(allocation_count, before);
#endif
}

}  // namespace
}  // namespace borelli::test::motion_efforts_test
