// Motion through singular positions, where branches cross: it stays on its branch, or the certificate names
// the place where it left it.
#include <Eigen/Geometry>
#include <array>
#include <numbers>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/singular_watch.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

constexpr double pi = std::numbers::pi;

/// IFToMM benchmark A02: n windows of uniform links, 1 kg and 1 m. The first n + 1 coordinates are the
/// cranks' angles from the line of their feet. The scene lies in the x-z plane turned by `tilt`. When all
/// links are in line, one row of each loop vanishes if tilt is 0; otherwise both rows coincide.
Scene windows(int n, double tilt, double rate) {
  Scene scene;
  scene.name = fmt::format("{} windows", n);
  const Matrix3d R = Eigen::AngleAxisd(tilt, -Vector3d::UnitY()).toRotationMatrix();
  scene.gravity = R * Vector3d(0, 0, -9.81);
  const Inertial link = inertial(1, {0.5, 0, 0}, {0, 1. / 12, 1. / 12});
  for (int i = 0; i <= n; ++i)
    scene.solids.push_back(solid(fmt::format("crank {}", i), "world",
                                 {fixed(R * Vector3d(i, 0, 0), R),
                                  hinge(fmt::format("crank {}", i), -Vector3d::UnitY(), pi / 2, rate)},
                                 {link}));
  for (int i = 0; i < n; ++i) {
    const std::string name = fmt::format("coupler {}", i), crank = fmt::format("crank {}", i + 1);
    scene.solids.push_back(solid(name, fmt::format("crank {}", i),
                                 {fixed({1, 0, 0}), hinge(name, -Vector3d::UnitY(), -pi / 2, -rate)},
                                 {link}));
    scene.constraints.push_back(
        {fmt::format("loop {}", i), PointOnPoint{{name, {1, 0, 0}}, {crank, {1, 0, 0}}}});
  }
  return scene;
}

void expect_benchmarks_end(int n, const Trajectory& t, double tolerance) {
  // where B0 is after 10 s: IFToMM A02, from theta's own equation by an eighth-order method
  const double x = n == 2 ? .328458111540815 : .180512226686728,
               z = n == 2 ? .944518538178601 : .983572740582312;
  const Eigen::VectorXd q = last(t.q);
  EXPECT_NEAR(std::cos(q[0]), x, tolerance);
  EXPECT_NEAR(std::sin(q[0]), z, tolerance);
  for (int i = 1; i <= n; ++i) EXPECT_NEAR(q[i], q[0], 1e-9);  // still a parallelogram
}

// Ten seconds of IFToMM A02 are ten passages through theta = 0 or pi.
TEST(Windows, TwoMatchTheBenchmark) {
  for (double tilt : {0., 0.6, 1.2})
    for (const char* method : {"rk4_adaptive", "dopri5", "dop853", "gbs", "gauss16"})
      for (double tolerance : {1e-9, 1e-11}) {
        SCOPED_TRACE(fmt::format("{} at {:g}, tilted by {}", method, tolerance, tilt));
        const Trajectory t = run(windows(2, tilt, -1), settings(method, 10, 1e-3, tolerance));
        EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
        // 1e-5 of the bars' length, 1e-6 J of about 70 J
        expect_benchmarks_end(2, t, 1e-5);
        EXPECT_LT(t.certificate.energy_drift, 1e-6);
        EXPECT_LT(t.certificate.nearness, 0.3);
        EXPECT_GT(t.certificate.nearness_time, 0.5);  // theta is first 0 at 0.714 s
      }
}

TEST(Windows, TwoWithFixedSteps) {
  for (double tilt : {0., 0.6})
    for (double step : {0.01, 0.001}) {
      const Trajectory t = run(windows(2, tilt, -1), settings("rk4", 10, step));
      EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
      expect_benchmarks_end(2, t, step == 0.01 ? 1e-5 : 1e-9);
    }
}

TEST(Windows, FortyMatchTheBenchmark) {
  for (const char* method : {"rk4_adaptive", "dop853"}) {
    SCOPED_TRACE(method);
    const Trajectory t = run(windows(40, 0, -1), settings(method, 10, 1e-3, 1e-9));
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    EXPECT_EQ(t.certificate.constraint_rank, 80);
    expect_benchmarks_end(40, t, 1e-5);
    EXPECT_LT(t.certificate.energy_drift, 1e-6);  // of 1200 J
  }
}

// Started in line, where the rank is n and n + 1 velocities are free, with the parallelogram's velocities.
TEST(Windows, StartInLine) {
  for (const char* method : {"rk4_adaptive", "dop853", "rk4"}) {
    SCOPED_TRACE(method);
    Scene scene = windows(2, 0.6, 5);
    for (Solid& one : scene.solids) one.switches.back().q = {0};
    const Trajectory t = run(scene, settings(method, 0.5, 1e-3, 1e-9));
    EXPECT_EQ(t.certificate.constraint_rank, 2);
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    EXPECT_LT(t.certificate.energy_drift, 1e-6);
    const Eigen::VectorXd q = last(t.q), v = last(t.v);
    EXPECT_NEAR(q[1], q[0], 1e-7);
    // I theta'' = -g (n + (n+1)/2) cos theta: its energy from theta = 0 at 5 rad/s
    EXPECT_NEAR(v[0] * v[0], 25 - 2 * 9.81 * 3.5 / 3 * std::sin(q[0]), 1e-5);
  }
}

/// Crank and coupler of 1 m and 1 kg, and a slider of 2 kg. When the slider passes the crank's pivot, the
/// coupler lies on the crank and could turn with it while the slider rests.
Scene isosceles_slider(double tilt, double start, double rate) {
  Scene scene;
  scene.gravity.setZero();
  const Matrix3d R = Eigen::AngleAxisd(tilt, -Vector3d::UnitY()).toRotationMatrix();
  const Inertial link = inertial(1, {0.5, 0, 0}, {0, 1. / 12, 1. / 12});
  scene.solids = {
      solid("crank", "world", {fixed({0, 0, 0}, R), hinge("crank", -Vector3d::UnitY(), start, rate)}, {link}),
      solid("coupler", "crank",
            {fixed({1, 0, 0}), hinge("coupler", -Vector3d::UnitY(), -2 * start, -2 * rate)}, {link}),
      solid("slider", "world",
            {fixed({0, 0, 0}, R),
             slide("slider", Vector3d::UnitX(), 2 * std::cos(start), -2 * std::sin(start) * rate)},
            {inertial(2, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"pin", PointOnPoint{{"coupler", {1, 0, 0}}, {"slider", {0, 0, 0}}}}};
  return scene;
}

TEST(IsoscelesSlider, PassesThroughTheCranksFoot) {
  // twice its kinetic energy over theta'^2, of the crank (1/3), the coupler (its centre at 1.5 cos, 0.5 sin;
  // 1/12) and the slider (2 cos): 1/3 + 1/12 + 1/4 + 2 sin^2 + 8 sin^2
  const auto inertia = [](double theta) { return 2. / 3 + 10 * std::sin(theta) * std::sin(theta); };
  const double start = 0.4, rate = 3, energy = inertia(start) * rate * rate, end_angle = 5.5;
  // the time to an angle past the singular positions at pi/2 and 3 pi/2: Simpson's rule, 2e4 strips
  double time = 0;
  const int strips = 20000;
  const double strip = (end_angle - start) / strips;
  for (int i = 0; i < strips; ++i)
    for (const auto& [at, weight] : {std::pair{0., 1.}, {.5, 4.}, {1., 1.}})
      time += weight * strip / 6 * std::sqrt(inertia(start + (i + at) * strip) / energy);
  for (double tilt : {0., 0.7})
    for (const char* method : {"rk4_adaptive", "dopri5", "dop853", "gbs", "gauss16", "rk4"}) {
      SCOPED_TRACE(fmt::format("{}, tilted by {}", method, tilt));
      const Trajectory t = run(isosceles_slider(tilt, start, rate), settings(method, time, 1e-3, 1e-9));
      EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
      const Eigen::VectorXd q = last(t.q), v = last(t.v);
      // the error of coasting through 1e-4 around a singular position, at most its square, plus the tolerance
      EXPECT_NEAR(q[0], end_angle, 1e-6);
      EXPECT_NEAR(q[1], -2 * end_angle, 2e-6);
      EXPECT_NEAR(q[2], 2 * std::cos(end_angle), 2e-6);
      EXPECT_NEAR(inertia(q[0]) * v[0] * v[0], energy, 1e-5);
    }
}

/// Bricard's mechanism over six edges of a cube (threefold symmetric, each link's hinges at right angles):
/// six hinges and five moving links, mobile although its freedoms count to 0; rods of 1 kg and 1 m.
Scene bricard() {
  Scene scene;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const std::array<Vector3d, 5> along = {x, y, z, -x, -y}, axis = {y, z, x, y, z};
  for (int i = 0; i < 5; ++i) {
    const Vector3d J = (Vector3d::Ones() - along[i].cwiseAbs()) / 12;
    std::vector<Switch> joint;
    if (i > 0) joint.push_back(fixed(along[i - 1]));
    joint.push_back(hinge(fmt::format("hinge {}", i), axis[i]));
    scene.solids.push_back(solid(fmt::format("rod {}", i), i ? fmt::format("rod {}", i - 1) : "world", joint,
                                 {inertial(1, along[i] / 2, J)}));
  }
  // the sixth hinge, about x at (0, 0, 1): two points of its axis
  for (double at : {0., 0.2})
    scene.constraints.push_back(
        {fmt::format("axis at {}", at), PointOnPoint{{"rod 4", along[4] + at * x}, {"world", z + at * x}}});
  return scene;
}

TEST(Bricard, MovesDespiteRedundantConstraints) {
  const Trajectory fine = run(bricard(), settings("dop853", 10, 1e-3, 1e-11));
  EXPECT_TRUE(fine.certificate.trusted) << fine.certificate.reason;
  EXPECT_EQ(fine.certificate.constraint_rank, 4);
  EXPECT_EQ(fine.certificate.redundant.size(), 2u);
  EXPECT_GT(fine.certificate.energy_turnover, 1);  // it moves
  EXPECT_LT(fine.certificate.energy_drift, 1e-7);
  EXPECT_EQ(fine.certificate.singular_passages, 0);
  for (const char* method : {"rk4_adaptive", "dopri5", "rk4", "gbs", "gauss16"}) {
    SCOPED_TRACE(method);
    const Trajectory t = run(bricard(), settings(method, 10, 1e-3, 1e-9));
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    EXPECT_EQ(t.certificate.singular_passages, 0);
    EXPECT_LT((last(t.q) - last(fine.q)).norm(), 1e-5);
  }
}

TEST(Crossing, IsPassedByInertia) {
  // a step ends at the crossing itself at t = 0.5 s
  const Certificate certificate = run(crossing(1, 0), settings("rk4", 1, 0.125)).certificate;
  EXPECT_TRUE(certificate.trusted) << certificate.reason;
  EXPECT_EQ(certificate.constraint_rank, 2);
  EXPECT_EQ(certificate.singular_passages, 1);
  EXPECT_LT(certificate.nearness, 1e-12);
  EXPECT_EQ(certificate.nearness_time, 0.5);
  ASSERT_EQ(certificate.events.size(), 2u);
  EXPECT_EQ(certificate.events[0].kind, "rank_fell");
  EXPECT_EQ(certificate.events[0].time, 0.5);
  EXPECT_TRUE(certificate.events[0].name == "constraint rows, to 1: 'saddle' depends on others" ||
              certificate.events[0].name == "constraint rows, to 1: 'level' depends on others")
      << certificate.events[0].name;  // they are parallel there
  EXPECT_EQ(certificate.events[1].kind, "rank_regained");
  EXPECT_EQ(certificate.events[1].time, 0.625);
  ASSERT_EQ(certificate.notes.size(), 1u);
  EXPECT_NE(certificate.notes[0].find(
                "singular position at t = 0.5 s, where the rank of the constraint rows falls to 1"),
            std::string::npos)
      << certificate.notes[0];
}

TEST(Crossing, DistrustsMotionPushedAside) {
  // a step that begins at the crossing coasts 0.125 s long under 10 m/s^2: 1.25 m/s aside
  const Certificate fixed_steps = run(crossing(1, 10), settings("rk4", 1, 0.125)).certificate;
  EXPECT_FALSE(fixed_steps.trusted);
  EXPECT_NE(fixed_steps.reason.find("jumped"), std::string::npos) << fixed_steps.reason;
  EXPECT_EQ(fixed_steps.reason_time, 0.625);
  // at 1 cm/s, a step of 1 ms from the crossing gains a sideways velocity as large as its own
  const Certificate slow = run(crossing(0.01, 10), settings("rk4", 1, 1e-3)).certificate;
  EXPECT_FALSE(slow.trusted);
  EXPECT_NEAR(slow.reason_time, 0.5, 0.01);
}

TEST(Crossing, DistrustsAStepOntoAnotherBranch) {
  // the shock's bar may go on or fold back when upright, too fast for steps of 1 ms
  const Scene scene = sample("shock.toml");
  SimulationSettings how = settings("rk4", 5, 1e-3);
  how.energy_threshold = 1e9;  // so coarse a run also loses energy, which is not tested here
  const Certificate coarse = run(scene, how).certificate;
  EXPECT_FALSE(coarse.trusted);
  EXPECT_NE(coarse.reason.find("left a singular position on another branch"), std::string::npos)
      << coarse.reason;
  EXPECT_NEAR(std::fmod(coarse.reason_time, 2 * std::sqrt(2 / 9.81)), std::sqrt(2 / 9.81),
              0.05);  // at a shock
}

TEST(SingularWatch, MeasuresJumpsAgainstTheGroupsOwnMotion) {
  const System system = compiled(windows(2, 0, -1));
  Workspace w(system);
  ASSERT_FALSE(
      accelerate(system, system.parameters, 0, system.initial.q.data(), system.initial.v.data(), {}, w));
  SingularWatch watch(system);
  Projection projection;
  projection.worst_row = Eigen::VectorXi::Constant(1, 1);
  projection.velocity_change =
      Eigen::VectorXd::Constant(1, 0.9e-2 * w.terms.kinetic);  // 0.095 of the velocity
  EXPECT_FALSE(watch.observe_projection(1, projection, w));
  projection.velocity_change[0] = 1.1e-2 * w.terms.kinetic;
  const auto reason = watch.observe_projection(1, projection, w);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("row '" + system.row_names[1] + "'"), std::string::npos) << *reason;
  EXPECT_NE(reason->find("jumped by 0.1 "), std::string::npos) << *reason;
}

}  // namespace
}  // namespace borelli::test
