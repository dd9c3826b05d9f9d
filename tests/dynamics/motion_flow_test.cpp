// The motion of a system as a differential equation: several states in lanes equal single states.
#include "dynamics/methods/motion_flow.hpp"

#include <Eigen/Eigenvalues>

#include "dynamics/equations/evaluate.hpp"
#include "random_scene.hpp"

namespace borelli::test {
namespace {

SimulationSettings recursive() {
  SimulationSettings settings;
  settings.equations = Equations::recursive;
  return settings;
}

/// A flow started at a random state.
struct Begun {
  Begun(const System& system, unsigned seed)
      : w(system, Equations::recursive),
        state(Random(seed).state(system)),
        settings(recursive()),
        flow(system, settings, w),
        y(flow.size()),
        dy(flow.size()),
        solved(flow.start(state, Work{system.groups}, y, dy)) {}
  Workspace w;
  State state;
  SimulationSettings settings;
  MotionFlow flow;
  Eigen::VectorXd y, dy;
  bool solved;
};

/// Condition of the mass matrix, the amplification of rounding in accelerations.
double condition(const System& system, const State& state) {
  const Eigen::MatrixXd A = need(evaluate(system, state)).mass_matrix;
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A).eigenvalues();
  return eigenvalues.maxCoeff() / eigenvalues.minCoeff();
}

template <class T>
void compare_lanes(const System& system, unsigned seed, const std::string& which) {
  Begun begun(system, seed);
  ASSERT_TRUE(begun.solved && begun.flow.has_lanes()) << which;
  Random random(seed + 100);
  Eigen::VectorX<T> y(begun.flow.size()), dy;
  std::vector<Eigen::VectorXd> each;
  for (int lane = 0; lane < T::count; ++lane) {
    Eigen::VectorXd& one = each.emplace_back(begun.y);
    for (int i = 0; i < 2 * system.nv; ++i) one[i] += random.number(-0.5, 0.5);
    for (Eigen::Index i = 0; i < one.size(); ++i) y[i].set(lane, one[i]);
  }
  const long before = begun.w.evaluations;
  ASSERT_TRUE(begun.flow.derivatives(y, 3, dy)) << which;
  EXPECT_EQ(begun.w.evaluations, before + 3) << which;
  ASSERT_EQ(dy.size(), begun.flow.size());
  for (int lane = 0; lane < T::count; ++lane) {
    Eigen::VectorXd slope;
    ASSERT_TRUE(begun.flow.derivative(0, each[lane], slope)) << which;
    State state = begun.state;
    Work work{system.groups};
    begun.flow.take(each[lane], state, work);
    const double bound = 1e-14 * condition(system, state);
    for (Eigen::Index i = 0; i < slope.size(); ++i)
      EXPECT_NEAR(dy[i][lane], slope[i], bound * slope.cwiseAbs().maxCoeff()) << which << ", " << i;
  }
}

void compare(const System& system, unsigned seed, const std::string& which) {
  compare_lanes<Quad>(system, seed, which + ", four");
  compare_lanes<Lanes>(system, seed, which + ", eight");
}

TEST(MotionFlow, LaneDerivativesEqualSingleOnes) {
  compare(compiled(chain(7, true)), 1, "chain");
  compare(compiled(roundabout()), 2, "roundabout");
  int acted = 0;
  for (unsigned seed = 0; seed < 30; ++seed)
    compare(compiled(random_tree(seed, {.balls = true})), seed, fmt::format("tree {}", seed));
  for (unsigned seed = 0; seed < 100; ++seed) {
    Scene scene = RandomScene(seed, 4, false).scene;
    std::get<Force>(scene.efforts[0].kind).factor = constant(0.7);
    std::get<Torque>(scene.efforts[1].kind).factor = constant(-1.2);
    const auto system = compile(scene);
    if (!system || system->nv == 0 || system->driven_nv > 0) continue;
    if (Begun begun(*system, seed); !begun.solved || !begun.flow.has_lanes()) continue;
    ++acted;
    compare(*system, seed, fmt::format("scene {}", seed));
  }
  EXPECT_GT(acted, 5);
}

TEST(MotionFlow, HasLanesForTimeInvariantBatchScenes) {
  const auto fits = [](const Scene& scene, Equations equations = Equations::recursive) {
    const System system = compiled(scene);
    Workspace w(system, equations);
    SimulationSettings settings;
    settings.equations = equations;
    return MotionFlow(system, settings, w).has_lanes();
  };
  EXPECT_TRUE(fits(chain(3, false)));
  EXPECT_FALSE(fits(chain(3, false), Equations::lagrange));
  EXPECT_FALSE(fits(bars(9)));  // all independent
  Scene scene = chain(3, false);
  scene.constraints = {{"tie", CoordinateCoupling{{{"h0"}, {"h1"}}, {1, -1}, constant(0)}}};
  EXPECT_FALSE(fits(scene));
  for (const bool steady : {true, false}) {
    scene = chain(3, false);
    Force push;
    push.at.solid = "l2";
    push.force = {3, 0, 0};
    if (!steady) push.factor = Sine{1, 2, 0, 0};
    scene.efforts = {{"push", push}};
    EXPECT_EQ(fits(scene), steady);
  }
}

// Two rotations about one line: elimination finds no inertia for the first.
TEST(MotionFlow, DropsItsLanesAfterASingularOne) {
  const System system = compiled(aligning_turns());
  Begun begun(system, 3);
  ASSERT_TRUE(begun.flow.has_lanes());
  Eigen::VectorX<Quad> y(begun.flow.size()), dy;
  for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = begun.y[i];
  ASSERT_TRUE(begun.flow.derivatives(y, 4, dy));
  EXPECT_TRUE(begun.flow.has_lanes());
  y[1].set(2, -begun.state.q[1]);  // the second angle comes to zero in one lane
  EXPECT_FALSE(begun.flow.derivatives(y, 4, dy));
  EXPECT_NE(begun.flow.failure(0).what.find("singular"), std::string::npos);
  EXPECT_FALSE(begun.flow.has_lanes());
}

}  // namespace
}  // namespace borelli::test
