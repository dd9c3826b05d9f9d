// Features so narrow that a step may jump over them: the kink of a stiff stop, a bump of a cam or of a wire.
// Against closed forms and quadrature.
#include <cmath>

#include "scenes.hpp"

namespace borelli::test::features_test {
namespace {

constexpr double g = 9.81;
constexpr const char* adaptive[] = {"rk4_adaptive", "dopri5", "dop853", "gbs", "gauss16"};

SimulationSettings to_accuracy(double end, double accuracy) {
  SimulationSettings how;
  how.end_time = end;
  how.accuracy = accuracy;
  return how;
}

// A mass thrown up at 10 m/s touches a stiff spring a little below its apex: free flight, a piece of an
// oscillation m z'' = -m g - k (z - bound), free flight.
TEST(Features, GrazedStopActs) {
  const double speed = 10, apex = speed * speed / (2 * g), k = 1e5, end = 1.5, w = std::sqrt(k);
  for (const double room : {0.1, 0.01, 0.001}) {
    const double bound = apex - room, meet = std::sqrt(2 * g * room);
    const double t_in = (speed - meet) / g, t_out = t_in + 2 * std::atan2(meet / w, g / (w * w)) / w;
    const double z = bound - meet * (end - t_out) - 0.5 * g * (end - t_out) * (end - t_out);
    Scene scene;
    scene.solids = {solid("mass", "world", {slide("z", Vector3d::UnitZ(), 0, speed)},
                          {inertial(1, {0, 0, 0}, {0.004, 0.004, 0.004})})};
    scene.efforts = {{"stop", LimitSpring{{"z"}, k, 0, {{-100, bound}}}}};
    std::vector<SimulationSettings> runs{to_accuracy(end, 1e-6)};
    for (const char* method : adaptive) runs.push_back(settings(method, end, 1e-2, 1e-9));
    runs.push_back(settings("rk4", end, 5e-5));
    for (const SimulationSettings& how : runs) {
      SCOPED_TRACE(fmt::format("{} m, {}", room, how.accuracy > 0 ? "by accuracy" : how.method));
      const Trajectory path = run(scene, how);
      EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
      EXPECT_NEAR(last(path.q)[0], z, 1e-5);  // an error of height changes the impact speed g / meet times
      ASSERT_EQ(path.certificate.events.size(), 2u);
      EXPECT_EQ(path.certificate.events[0].kind, "stop_reached");
      EXPECT_NEAR(path.certificate.events[0].time, t_in, 1e-6);
      EXPECT_EQ(path.certificate.events[1].kind, "stop_left");
      EXPECT_NEAR(path.certificate.events[1].time, t_out, 1e-6);
    }
  }
}

/// Level ground with one knot at 5 m raised by `height`; knots are `apart`.
Table bump(double apart, double height) {
  std::vector<double> at{-1000}, values{0};
  for (int i = -40; i <= 40; ++i) {
    at.push_back(5 + i * apart);
    values.push_back(i == 0 ? height : 0);
  }
  at.push_back(1000);
  values.push_back(0);
  return {at, values};
}

/// A slider of 1 kg at 1 m/s carries a follower of 1 kg towards the bump. The bump takes 9.8 J, while the
/// slider has 0.5 J (1 J with the follower).
Scene cam(const Table& table) {
  Scene scene;
  Switch follow = slide("z", Vector3d::UnitZ());
  follow.q.clear();
  follow.v.clear();
  follow.motion = Coupled{"x", table};
  const Inertial one = inertial(1, {0, 0, 0}, {0.004, 0.004, 0.004});
  scene.solids = {solid("slider", "world", {slide("x", Vector3d::UnitX(), 0, 1)}, {one}),
                  solid("follower", "slider", {follow}, {one})};
  return scene;
}

// (2 + f'^2) x'^2 / 2 + g f = 1 - f(0)...: with E the energy at the start, the time to the turning point is
// the integral of sqrt((2 + f'^2) / (2 (E - g f))); x = turn - s^2 takes out the root's pole.
double returns_to(const Table& f, double end) {
  const auto at = [&](double x) { return f(x); };
  const double E = 0.5 * (2 + at(0).rate * at(0).rate) + g * at(0).value;
  double turn = 0;
  while (g * at(turn).value < E) turn += 1e-5;
  double low = turn - 1e-5;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + turn) / 2;
    (g * at(middle).value < E ? low : turn) = middle;
  }
  const auto slowness = [&](double s) {  // dt / ds
    const TimeValue v = at(turn - s * s);
    return 2 * s * std::sqrt((2 + v.rate * v.rate) / (2 * (E - g * v.value)));
  };
  // midpoint rule, which avoids the pole: outwards from the turning point until the time is used up
  const auto time_to = [&](double x) {
    const double reach = std::sqrt(turn - x);
    const int n = 400000;
    double t = 0;
    for (int i = 0; i < n; ++i) t += slowness((i + 0.5) * reach / n);
    return t * reach / n;
  };
  const double back = end - time_to(0);
  double near = turn, far = 0;
  for (int i = 0; i < 40; ++i) {
    const double middle = (near + far) / 2;
    (time_to(middle) < back ? near : far) = middle;
  }
  return (near + far) / 2;
}

TEST(Features, CamTurnsBackASlowFollower) {
  for (const double apart : {0.001, 0.01, 0.1}) {
    const Table table = bump(apart, 1);
    const double x = returns_to(table, 8);
    ASSERT_LT(x, 4);
    std::vector<SimulationSettings> runs{to_accuracy(8, 1e-6)};
    for (const char* method : adaptive) runs.push_back(settings(method, 8, 1e-2, 1e-9));
    for (const SimulationSettings& how : runs) {
      SCOPED_TRACE(fmt::format("{} m, {}", apart, how.accuracy > 0 ? "by accuracy" : how.method));
      const Trajectory path = run(cam(table), how);
      EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
      EXPECT_NEAR(last(path.q)[0], x, 2e-5);
    }
  }
}

TEST(Features, FixedStepsThatSkipABumpAreDistrusted) {
  const Trajectory path = run(cam(bump(0.001, 1)), settings("rk4", 8, 0.05));
  EXPECT_FALSE(path.certificate.trusted);
  EXPECT_NE(path.certificate.reason.find("miss changes of the function of constraint"), std::string::npos)
      << path.certificate.reason;
}

// Over smooth ground a table with many knots costs no more steps than the sine that it was made from.
TEST(Features, ManyKnotsOfASmoothTableDoNotShortenSteps) {
  std::vector<double> at, values;
  for (int i = 0; i <= 20000; ++i) {
    at.push_back(-1 + i * 5e-4);
    values.push_back(0.02 * std::sin(3 * at.back()));
  }
  Scene by_table = cam({at, values}), by_sine = by_table;
  std::get<Coupled>(by_sine.solids[1].switches[0].motion).function = Sine{0.02, 3, 0, 0};
  const SimulationSettings how = settings("dop853", 8, 1e-2, 1e-6);
  const Trajectory table = run(by_table, how), sine = run(by_sine, how);
  EXPECT_TRUE(table.certificate.trusted) << table.certificate.reason;
  EXPECT_NEAR(last(table.q)[0], last(sine.q)[0], 1e-5);
  EXPECT_LT(table.certificate.steps_accepted, 1.2 * sine.certificate.steps_accepted);
}

// A bead with 0.5 J and a weight of 100 N meets a wire raised by 5 cm, which takes 5 J. It turns back 5 mm
// up. The wire is level except for the spline's ripples near the bump.
TEST(Features, WireTurnsBackASlowBead) {
  PointOnCurve wire;
  wire.point = {"bead", {0, 0, 0}};
  wire.curve = {"world"};
  for (int i = -1; i <= 3; ++i) wire.through.push_back({double(i), 0, 0});
  for (int i = -20; i <= 20; ++i) wire.through.push_back({5 + 0.05 * i, 0, i == 0 ? 0.05 : 0});
  for (int i = 7; i <= 11; ++i) wire.through.push_back({double(i), 0, 0});
  Scene scene;
  scene.gravity = {0, 0, -100};
  scene.solids = {solid("bead", "world", {slide("x", Vector3d::UnitX(), 0, 1), slide("z", Vector3d::UnitZ())},
                        {inertial(1, {0, 0, 0}, {0.004, 0.004, 0.004})})};
  scene.constraints = {{"wire", wire}};
  for (const char* method : adaptive) {
    SCOPED_TRACE(method);
    const Trajectory path = run(scene, settings(method, 8, 1e-2, 1e-8));
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    EXPECT_LT(last(path.q)[0], 4);
    EXPECT_NEAR(last(path.v)[0], -1, 1e-3);  // back on level ground with its first speed
  }
}

TEST(Features, EstimatedErrorOfChaosIsMeaningful) {
  Scene scene = chain(3, false, 2);
  const Trajectory path = run(scene, to_accuracy(60, 1e-6));
  ASSERT_FALSE(path.certificate.trusted);
  // two runs' angles and rates: hundreds at most, and their tolerances differ
  EXPECT_LT(path.certificate.estimated_error, 1e3) << path.certificate.reason;
}

}  // namespace
}  // namespace borelli::test::features_test
