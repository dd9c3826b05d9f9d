// What a run records, when its observer may stop it, and which coordinates it notes beyond their range.
#include "dynamics/run/simulate.hpp"

#include <cmath>

#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"

namespace borelli::test::simulate_output_test {
namespace {

TEST(Output, RowsComeAtTheRequestedTimes) {
  for (const char* method : {"rk4", "rk4_adaptive"}) {
    SimulationSettings how = settings(method, 1, 0.03, 1e-8);
    how.output_interval = 0.3;
    const Trajectory path = run(roundabout(), how);
    EXPECT_EQ(path.times, (std::vector<double>{0, 0.3, 0.6, 3 * 0.3, 1})) << method;
    EXPECT_EQ(path.q.rows(), 5);
    EXPECT_EQ(path.kinetic.size(), 5u);
    EXPECT_EQ(path.poses.size(), 15u);
    double sum = 0;
    for (double h : path.step_sizes) sum += h;
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  SimulationSettings every = settings("rk4", 1, 0.1);
  every.output_interval = 0;
  EXPECT_EQ(run(roundabout(), every).times.size(), 11u);
}

TEST(Output, EveryArrayHasARowPerTime) {
  const System system = compiled(roundabout());
  for (const double interval : {0.0, 0.5}) {  // 0: every step, more rows than are first reserved
    SimulationSettings settings = system.settings;
    settings.method = "rk4", settings.step = 1e-3, settings.end_time = 2, settings.output_interval = interval;
    const Trajectory motion = need(simulate(system, system.initial, settings));
    const auto count = Eigen::Index(motion.times.size());
    EXPECT_EQ(count, interval == 0 ? 2001 : 5);
    for (const Rows* numbers : {&motion.q, &motion.v, &motion.a}) {
      EXPECT_EQ(numbers->rows(), count);
      EXPECT_EQ(numbers->cols(), 3);
    }
    for (const Rows* none : {&motion.multipliers, &motion.contact_modes, &motion.contact_forces,
                             &motion.driven_positions, &motion.driven_efforts}) {
      EXPECT_EQ(none->rows(), count);
      EXPECT_EQ(none->cols(), 0);
    }
    for (const Rows* numbers : {&motion.gravity_centre, &motion.linear_momentum, &motion.angular_momentum})
      EXPECT_EQ(numbers->rows(), count);
    EXPECT_EQ(motion.poses.size(), motion.times.size() * motion.solids.size());
    // each row equals the evaluation of its state alone
    for (const Eigen::Index row : {Eigen::Index(1), count / 2, count - 1}) {
      const State at{motion.times[std::size_t(row)], motion.q.row(row).transpose(),
                     motion.v.row(row).transpose()};
      const Evaluation alone = need(evaluate(system, at));
      EXPECT_LT((alone.acceleration - motion.a.row(row).transpose()).norm(), 1e-9);
      EXPECT_LT((alone.momenta.angular - motion.angular_momentum.row(row).transpose()).norm(), 1e-9);
      EXPECT_LT((alone.momenta.centre - motion.gravity_centre.row(row).transpose()).norm(), 1e-12);
    }
  }
}

TEST(Output, PosesMatchTheCoordinates) {
  const Trajectory path = run(roundabout(), settings("rk4", 0.5, 0.01));
  const Eigen::VectorXd q = last(path.q);
  const Matrix3d turn = rotation_about(Vector3d::UnitZ(), q[0]);
  EXPECT_LT((path.pose(1, 1).p - turn * Vector3d(0.5, 0, 0)).norm(), 1e-14);
  EXPECT_LT((path.pose(1, 1).R - turn * rotation_about(Vector3d::UnitY(), q[1])).norm(), 1e-14);
}

TEST(Output, DrivenCoordinatesAreRecordedWithTheirEfforts) {
  Scene scene = roundabout();
  scene.solids[0].switches[0] = driven(scene.solids[0].switches[0], Polynomial{{0, 0, 1.5}});
  const Trajectory path = run(scene, settings("rk4", 1, 0.01));
  EXPECT_EQ(path.driven_names, std::vector<std::string>{"dof1"});
  EXPECT_NEAR(path.driven_positions(1, 0), 1.5, 1e-14);
  EXPECT_GT(path.driven_efforts(0, 0), 3 * 1.25);  // more than the turntable alone needs
}

TEST(Output, ObserverCanStopTheRun) {
  const System system = compiled(roundabout());
  int calls = 0;
  const Trajectory path = need(simulate(system, system.initial, settings("rk4", 1, 0.01), {[&](double t) {
                                          ++calls;
                                          return t < 0.5;
                                        }}));
  EXPECT_EQ(calls, 50);
  EXPECT_NEAR(path.times.back(), 0.5, 1e-12);
  EXPECT_FALSE(path.certificate.trusted);
  EXPECT_EQ(path.certificate.reason, "stopped on request at t = 0.5 s of 1 s");
}

TEST(Output, NotesACoordinateThatLeavesItsRange) {
  Scene scene = chain(1, false, 0.5);
  scene.solids[0].switches[0].ranges = {{-0.2, 0.6}};
  const Certificate certificate = run(scene, settings("rk4", 2, 0.01)).certificate;
  ASSERT_EQ(certificate.notes.size(), 1u);
  EXPECT_NE(certificate.notes[0].find("coordinate 'h0' left its range of -0.2 to 0.6 at t"),
            std::string::npos);
}

TEST(Output, NotesAxisAndTimeOfABallOutsideItsRange) {
  // A sphere on a rod, let go at rest 1 rad from hanging, in a plane whose normal is one of the ball's
  // axes. It swings as sin(angle / 2) = k sn(K - t w), k = sin(1 / 2), w^2 = m g l / (m l^2 + i) (e.g. Landau
  // & Lifshitz, Mechanics, section 11), so it passes an angle at (K - F(asin(sin(angle / 2) / k))) / w.
  const double m = 2, l = 0.7, i = 0.05, start = 1, limit = -0.4, k = std::sin(start / 2);
  const double t = (std::comp_ellint_1(k) - std::ellint_1(k, std::asin(std::sin(limit / 2) / k))) *
                   std::sqrt((l + i / (m * l)) / 9.81);
  for (int axis = 0; axis < 2; ++axis) {
    Switch joint = ball("b", exponential(start * Vector3d::Unit(axis)));
    joint.ranges = {{-0.1, 1.1}, {-0.1, 1.1}, {-0.1, 0.1}};
    joint.ranges[axis].lower = limit;
    Scene scene;
    scene.solids = {solid("bob", "world", {joint}, {inertial(m, {0, 0, -l}, {i, i, i})})};
    const double step = 1e-4;
    const Certificate certificate = run(scene, settings("rk4", t + 0.1, step)).certificate;
    ASSERT_EQ(certificate.notes.size(), 1u);
    const std::string& note = certificate.notes[0];
    const std::string said =
        fmt::format("coordinate 'b' left its range of -0.4 to 1.1 about its {} axis at t = ", "xyz"[axis]);
    ASSERT_TRUE(note.starts_with(said)) << note;
    const double noted = std::stod(note.substr(said.size()));
    // at the end of the step in which it left; the note has six digits
    EXPECT_GT(noted, t - 1e-6);
    EXPECT_LT(noted, t + step + 1e-6);
  }
}

}  // namespace
}  // namespace borelli::test::simulate_output_test
