// States between steps: output shortens no step, lies on the constraints and is as exact as the steps; fewer
// evaluations; whole runs by methods with dense output against references.
#include "dynamics/run/step_path.hpp"

#include <cmath>

#include "scenes.hpp"

namespace borelli::test::step_path_test {
namespace {

Scene constrained_point() {  // IFToMM's A01
  Scene scene;
  scene.solids = {solid("point", "world",
                        {slide("x", Vector3d::UnitX(), -1), slide("z", Vector3d::UnitZ(), 0)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"rod", Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}}};
  return scene;
}
const Eigen::Vector2d a01(-.275087462576117, -.961419205099125);

TEST(DenseOutput, DoesNotShortenSteps) {
  for (const char* method : {"dopri5", "dop853"})
    for (const Scene& scene : {roundabout(), constrained_point()}) {
      const System system = compiled(scene);
      SimulationSettings how = settings(method, 2, 0.01, 1e-8);
      const Trajectory ends = run(system, how);
      how.output_interval = 0.001;
      const Trajectory path = run(system, how);
      EXPECT_EQ(path.times.size(), 2001u) << method;
      EXPECT_EQ(path.step_sizes, ends.step_sizes) << method;
      EXPECT_LT(ends.step_sizes.size(), 400u) << method;
      EXPECT_EQ(last(path.q), last(ends.q)) << method;
      EXPECT_TRUE(path.certificate.trusted) << method << ": " << path.certificate.reason;
    }
}

TEST(DenseOutput, IsAsAccurateAsTheSteps) {
  const System system = compiled(roundabout());
  SimulationSettings fine = settings("rk4_adaptive", 2, 0.01, 1e-12);
  fine.output_interval = 0.05;
  const Trajectory reference = run(system, fine);
  for (const char* method : {"dopri5", "dop853"}) {
    SimulationSettings how = settings(method, 2, 0.01, 1e-8);
    how.output_interval = 0.05;
    const Trajectory path = run(system, how);
    const double at_end = std::max((last(path.q) - last(reference.q)).norm(), 1e-8);
    EXPECT_EQ(path.times, reference.times);
    // an interpolant of one order less adds a few times the steps' error at most
    EXPECT_LT((path.q - reference.q).rowwise().norm().maxCoeff(), 5 * at_end) << method;
    EXPECT_LT((path.v - reference.v).rowwise().norm().maxCoeff(), 1e-5) << method;
    // energy minus work is constant at every row
    for (std::size_t i = 0; i < path.times.size(); ++i)
      EXPECT_NEAR(path.kinetic[i] + path.potential[i] - path.work[i], path.kinetic[0] + path.potential[0],
                  1e-5)
          << method;
  }
}

TEST(DenseOutput, LiesOnTheConstraints) {
  for (const char* method : {"dopri5", "dop853"}) {
    SimulationSettings how = settings(method, 10, 0.01, 1e-10);
    how.output_interval = 0.01;
    const Trajectory path = run(constrained_point(), how);
    EXPECT_LT((last(path.q) - a01).norm(), 1e-8) << method;
    for (Eigen::Index i = 0; i < path.q.rows(); ++i) {
      EXPECT_NEAR(path.q.row(i).norm(), 1, 1e-12) << method;
      EXPECT_NEAR(path.q.row(i).dot(path.v.row(i)), 0, 1e-12) << method;
      // m v^2 / l + m g cos of the angle from below, pulling inwards
      EXPECT_NEAR(path.multipliers(i, 0), -(path.v.row(i).squaredNorm() - 9.81 * path.q(i, 1)), 1e-9)
          << method;
    }
    EXPECT_LT(path.certificate.residuals[0].position, 1e-12);
  }
}

TEST(DenseOutput, KeepsAFixedStepUnderCloserRows) {
  const System system = compiled(roundabout());
  SimulationSettings how = settings("rk4", 1, 0.01);
  how.output_interval = 0.0025;
  const Trajectory path = run(system, how);
  EXPECT_EQ(path.times.size(), 401u);
  EXPECT_EQ(path.step_sizes.size(), 100u);
  how.step = 0.0025;
  const Trajectory fine = run(system, how);
  // Hermite's cubic has an error of h^4 / 384 times the fourth derivative, 1e4 at 10 rad/s; otherwise rows
  // between steps are as exact as those at their ends
  double at_ends = 0, between = 0;
  for (Eigen::Index i = 0; i < path.q.rows(); ++i)
    (i % 4 == 0 ? at_ends : between) =
        std::max(i % 4 == 0 ? at_ends : between, (path.q.row(i) - fine.q.row(i)).cwiseAbs().maxCoeff());
  EXPECT_GT(at_ends, 0);
  EXPECT_LT(between, at_ends + 1e-6);
}

TEST(FirstSameAsLast, SavesTheEvaluationAtTheStepsEnd) {
  const System system = compiled(roundabout());
  const Certificate five = run(system, settings("dopri5", 1, 0.01, 1e-8)).certificate;
  // one at the start, and six per step: the last is the next one's first
  EXPECT_EQ(five.evaluations, 1 + 6 * (five.steps_accepted + five.steps_rejected));
  const Certificate eight = run(system, settings("dop853", 1, 0.01, 1e-8)).certificate;
  EXPECT_EQ(eight.evaluations, 1 + 12 * eight.steps_accepted + 11 * eight.steps_rejected);
}

TEST(Methods, OfHigherOrderReachTheHeavyTopsReference) {
  // Arnold and Bruels' heavy top (see simulate_test.cpp), 2 s at 150 rad/s
  Scene scene;
  scene.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {0, 150, -4.61538})},
                        {inertial(15, {0, 1, 0}, {0.234375, 0.46875, 0.234375})})};
  const Vector3d centre(-.15041682275, -.72416559164, -.67302226956);
  const System system = compiled(scene);
  for (const char* method : {"dopri5", "dop853", "gbs", "gauss16"}) {
    const Trajectory end = run(system, settings(method, 2, 0.001, 1e-12));
    EXPECT_LT((Vector3d(last(end.gravity_centre)) - centre).norm(), 1e-9) << method;
    EXPECT_TRUE(end.certificate.trusted) << method << ": " << end.certificate.reason;
  }
}

TEST(Methods, HighOrderCostsLessAtTightTolerances) {
  const System system = compiled(roundabout());
  const long doubling = run(system, settings("rk4_adaptive", 5, 0.01, 1e-11)).certificate.evaluations;
  for (const char* method : {"dop853", "gbs", "gauss16"}) {
    const Trajectory end = run(system, settings(method, 5, 0.01, 1e-11));
    // the roundabout's reference (see simulate_test.cpp)
    EXPECT_LT((last(end.q) - Vector3d(36.589803206456790, -.491961391081574, .009149081659433)).norm(), 1e-8)
        << method;
    EXPECT_LT(3 * end.certificate.evaluations, doubling) << method;
  }
}

TEST(Methods, NamesABallThatTurnsTooFarInAStep) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {1, 0, 700})},
                        {inertial(1, {0, 0, 0}, {1, 1, 1.6})})};
  const System system = compiled(scene);
  const auto out = simulate(system, system.initial, settings("rk4", 1, 0.01));
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().where, "coordinate 'turn'");
  EXPECT_NE(out.error().what.find("turns by more than 5 rad in one step"), std::string::npos)
      << out.error().what;
  EXPECT_TRUE(simulate(system, system.initial, settings("dop853", 1, 0.01)));  // takes smaller ones
}

}  // namespace
}  // namespace borelli::test::step_path_test
