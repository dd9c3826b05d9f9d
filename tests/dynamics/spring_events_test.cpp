// Springs with kinks or jumps (stops, half turns): no step passes over them.
#include "dynamics/run/spring_events.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scenes.hpp"

namespace borelli::test::spring_events_test {
namespace {

using std::numbers::pi;

// A mass on a spring swings against a stop and returns with the same speed: cos t outside, and within the
// stop a faster oscillation about another centre. Steps may span half a swing, while a stiff or barely
// reached stop acts for a small part of one.
TEST(SpringEvents, FindsStopsWithinLongSteps) {
  const double end = 20;
  for (const double stiffness : {1e-2, 1., 1e2, 1e3, 1e5, 1e7, 1e9})
    for (const double stop : {-0.999, -0.95, -0.5, -0.1}) {
      const double arrival = std::acos(stop), speed = std::sin(arrival), w = std::sqrt(1 + stiffness);
      const double from_centre = stop / (1 + stiffness), held = 2 / w * std::atan2(speed, -w * from_centre),
                   period = 2 * arrival + held;
      const double t = std::fmod(end, period), in_stop = w * (t - arrival);
      const double x = t < arrival            ? std::cos(t)
                       : t < period - arrival ? stop - from_centre + from_centre * std::cos(in_stop) -
                                                    speed / w * std::sin(in_stop)
                                              : std::cos(period - t);
      const std::size_t bounds = 2 * std::size_t(end / period) + (t > arrival) + (t > arrival + held);
      Scene scene;
      scene.gravity.setZero();
      scene.solids = {
          solid("mass", "world", {slide("x", Vector3d::UnitX(), 1)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
      scene.efforts = {{"spring", CoordinateSpring{{"x"}, 1, 0, 0}},
                       {"stop", LimitSpring{{"x"}, stiffness, 0, {{stop, 2}}}}};
      for (const char* method : {"gauss16", "gbs", "gbs4", "dop853", "dopri5", "rk4_adaptive", "arkode"})
        for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11}) {
          const Trajectory out = run(scene, settings(method, end, 1e-3, tolerance));
          const std::string which = fmt::format("{} {:g} {:g} {:g}", method, tolerance, stiffness, stop);
          EXPECT_TRUE(out.certificate.trusted || tolerance > 1e-4) << which;
          // arkode damps oscillations much faster than its steps
          if (tolerance > 1e-4 && !out.certificate.trusted) continue;
          // per step one tolerance of position and (1 + |v|) tolerances of speed, which the swing mixes; an
          // error of the amplitude changes whether and when it reaches the stop
          const double error = std::sqrt(5.) * double(out.certificate.steps_accepted) * tolerance;
          if (error < 1 + stop) {
            EXPECT_EQ(out.certificate.events.size(), bounds) << which;
          }
          EXPECT_NEAR(last(out.q)[0], x, error / speed) << which;
        }
    }
}

// Up to the half turn the wheel swings as A sin(w t); there it starts again from the other side.
TEST(SpringEvents, WheelPassesHalfTurnsAtClosedFormTimes) {
  const double stiffness = 2, speed = 6, w = std::sqrt(stiffness / 0.8), end = 4;
  ASSERT_GT(speed / w, pi);
  const auto half = [&](double start) { return std::asin(pi * w / start) / w; };  // first half turn, s
  const auto turns = [&](double start) { return std::floor((end + half(start)) / (2 * half(start))); };
  const auto angle = [&](double start) {
    return 2 * pi * turns(start) + start / w * std::sin(w * (end - 2 * half(start) * turns(start)));
  };
  // their change by a relative error of the speed
  const double faster = (1 + 1e-6) * speed;
  const double half_follows = std::abs(half(faster) - half(speed)) / 1e-6,
               angle_follows = std::abs(angle(faster) - angle(speed)) / 1e-6;
  const Scene scene = wheel(stiffness, speed);
  for (const char* method : {"gbs", "gauss16", "dop853", "dopri5", "gbs4"})
    for (const double tolerance : {1e-5, 1e-8, 1e-11}) {
      SimulationSettings how = settings(method, end, 0.1);
      how.tolerance = tolerance;
      const Trajectory out = run(scene, how);
      const auto& log = out.certificate.events;
      EXPECT_EQ(std::count_if(log.begin(), log.end(), [](const auto& e) { return e.kind == "half_turn"; }),
                long(turns(speed)));
      // one tolerance per step, of the angle and of the speed
      const double error = tolerance * out.certificate.steps_accepted;
      EXPECT_NEAR(log.front().time, half(speed), error * (1 / speed + half_follows)) << method << tolerance;
      EXPECT_NEAR(last(out.q)[0], angle(speed), error * (1 + angle_follows)) << method << tolerance;
      if (tolerance < 1e-5) {
        EXPECT_TRUE(out.certificate.trusted) << method << tolerance;
      }
    }
}

// A spring so weak that the method would take steps of many turns.
TEST(SpringEvents, FindsAllHalfTurnsOfAFastWheel) {
  SimulationSettings how = settings("gbs", 1, 0.1);
  how.tolerance = 1e-6;
  const Trajectory out = run(wheel(1e-6, 100), how);
  EXPECT_EQ(out.certificate.events.size(), 16u);  // 100 rad
  EXPECT_TRUE(out.certificate.trusted);
}

// Without a fixed axis, half turns may be passed on any side. The two methods share only the event search.
TEST(SpringEvents, HalfTurnsOfTumblingBodiesAgreeBetweenMethods) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Scene scene;
    scene.gravity.setZero();
    scene.solids = {solid("a", "world", {ball("turn_a")}, {inertial(1, random.vector(0.1), {1, 1.2, 0.8})}),
                    solid("b", "a", {ball("turn_b")}, {inertial(1, random.vector(0.1), {0.5, 0.6, 0.7})})};
    for (Solid& one : scene.solids) one.switches[0].v = {random.number(-6, 6), random.number(-6, 6), 5};
    TorsionSpring spring;
    spring.a.solid = "b";
    spring.b.solid = "a";
    spring.stiffness = 0.5;
    spring.damping = 0.02;
    spring.rest = random.vector(1);
    scene.efforts = {{"spring", spring}};
    SimulationSettings how = settings("dop853", 2, 0.1);
    how.tolerance = 1e-12;
    const Trajectory truth = run(scene, how);
    how.method = "gbs";
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
      how.tolerance = tolerance;
      const Trajectory out = run(scene, how);
      EXPECT_EQ(out.certificate.events.size(), truth.certificate.events.size()) << seed << ", " << tolerance;
      // one tolerance per step, which some motions amplify
      EXPECT_LT((last(out.q) - last(truth.q)).cwiseAbs().maxCoeff(),
                100 * tolerance * out.certificate.steps_accepted)
          << seed << ", " << tolerance;
    }
  }
}

// x'' = -g - k x max(0, 1 + d x') beyond the bound at 0, by the classical method of Runge and Kutta in a
// million steps.
TEST(SpringEvents, FindsAStopThatGoesSlack) {
  const double g = 9.81, k = 50, d = 0.5, end = 0.4;
  for (int n = 0; n < 10; ++n) {
    const double start = 0.6 + 0.05 * n;
    const auto acceleration = [&](double x, double v) {
      return x > 0 ? -g - k * x * std::max(0.0, 1 + d * v) : -g;
    };
    double x = start, v = 1;
    const int steps = 1000000;
    const double h = end / steps;
    for (int i = 0; i < steps; ++i) {
      const double a1 = acceleration(x, v), v2 = v + 0.5 * h * a1, a2 = acceleration(x + 0.5 * h * v, v2),
                   v3 = v + 0.5 * h * a2, a3 = acceleration(x + 0.5 * h * v2, v3), v4 = v + h * a3,
                   a4 = acceleration(x + h * v3, v4);
      x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
      v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    Scene scene;
    scene.gravity = {0, 0, -g};
    scene.solids = {solid("mass", "world", {slide("z", Vector3d::UnitZ(), start, 1)},
                          {inertial(1, {0, 0, 0}, {0, 0, 0})})};
    scene.efforts = {{"stop", LimitSpring{{"z"}, k, d, {{-100, 0}}}}};
    for (const char* method : {"gbs", "gauss16", "dop853", "dopri5"})
      for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
        SimulationSettings how = settings(method, end, 0.1);
        how.tolerance = tolerance;
        const Trajectory out = run(scene, how);
        std::string events;
        for (const LoggedEvent& event : out.certificate.events) events += event.kind + " ";
        EXPECT_EQ(events, "stop_slack stop_left ") << method << tolerance;
        EXPECT_TRUE(out.certificate.trusted) << method << tolerance << out.certificate.reason;
        const double error = 10 * tolerance * out.certificate.steps_accepted;
        EXPECT_NEAR(last(out.q)[0], x, error) << method << tolerance;
        EXPECT_NEAR(last(out.v)[0], v, error) << method << tolerance;
      }
  }
}

// Chains fly against stops of all stiffnesses: wide ranges, ranges of width zero, and a ball's; half of them
// dissipate so much that they go slack. Reference: two methods at far smaller tolerances, which must agree.
TEST(SpringEvents, ChainsBetweenStopsMatchSmallSteps) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    Random random(seed);
    Scene scene;
    scene.gravity = {0, 0, -9.81};
    const std::array<std::string, 4> names{"world", "a", "b", "c"};
    for (std::size_t b = 1; b < names.size(); ++b) {
      const std::string joint = "turn_" + names[b];
      const bool is_ball = b == 2 && seed % 2 == 1;
      const Switch turns =
          is_ball ? ball(joint)
                  : hinge(joint, Vector3d::UnitY(), random.number(-0.3, 0.3), random.number(-2, 2));
      scene.solids.push_back(
          solid(names[b], names[b - 1], {turns}, {inertial(1, random.vector(0.3), {0.1, 0.12, 0.08})}));
      LimitSpring stop{{joint}, std::pow(10, random.number(1, 5)), std::max(0., random.number(-1, 1)), {}};
      if (is_ball)
        stop.range = {{-0.5, 0.4}, {-0.4, 0.4}, {-0.3, 0.3}};
      else if (seed % 3 == 2)
        stop.range = {{0.1, 0.1}};
      else
        stop.range = {{random.number(-0.8, -0.3), random.number(0.3, 0.8)}};
      scene.efforts.push_back({"stop_" + names[b], stop});
    }
    const Eigen::VectorXd truth = last(run(scene, settings("rk4_adaptive", 1, 1e-3, 1e-11)).q);
    const double unsure =
        (last(run(scene, settings("dop853", 1, 1e-3, 1e-12)).q) - truth).cwiseAbs().maxCoeff();
    ASSERT_LT(unsure, 1e-8) << seed;
    for (const char* method : {"gauss16", "gbs", "dop853", "dopri5", "arkode"})
      for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
        const Trajectory out = run(scene, settings(method, 1, 1e-3, tolerance));
        EXPECT_TRUE(out.certificate.trusted) << method << tolerance << ", " << seed;
        // one tolerance per step, which impacts amplify
        EXPECT_LT((last(out.q) - truth).cwiseAbs().maxCoeff(),
                  100 * (tolerance * double(out.certificate.steps_accepted) + unsure))
            << method << tolerance << ", " << seed;
      }
  }
}

}  // namespace
}  // namespace borelli::test::spring_events_test
