// Fixed steps too long to follow the motion: the measure against closed forms, and the verdicts.
#include "dynamics/run/step_watch.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "dynamics/methods/integrator.hpp"
#include "scenes.hpp"

namespace borelli::test::step_watch_test {
namespace {

constexpr double pi = std::numbers::pi;

/// 1 kg on a spring: x = cos(w t) if it starts at 1.
Scene spring(double stiffness, double start = 1) {
  Scene scene;
  scene.name = "spring";
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), start)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, stiffness, 0, 0}}};
  return scene;
}

/// A point on a rod whose small swings take one second.
Scene second_pendulum(double start = 0.2) {
  Scene scene;
  scene.name = "pendulum";
  const double length = 9.81 / (4 * pi * pi);
  scene.solids = {solid("bob", "world", {hinge("swing", Vector3d::UnitY(), start)},
                        {inertial(1, {0, 0, -length}, {0, 0, 0})})};
  return scene;
}

std::vector<std::string> fixed_methods() {
  std::vector<std::string> names;
  for (const std::string& name : integrator_names())
    if (!method_is_adaptive(name)) names.push_back(name);
  return names;
}

/// The measure for x = cos(t) after a thousand steps of length b, for a method of that order.
double found_of_a_swing(const System& system, double b, int order) {
  StepWatch watch(system);
  for (int i = 0; i <= 1000; ++i) {
    const double t = i * b;
    watch.observe({t, Eigen::VectorXd::Constant(1, std::cos(t)), Eigen::VectorXd::Constant(1, -std::sin(t))},
                  Eigen::VectorXd::Constant(1, -std::cos(t)), true);
  }
  EXPECT_EQ(watch.worst(order).coordinate, 0);
  return watch.worst(order).part;
}

TEST(StepWatch, MeasuresASwingAsInClosedForm) {
  const System system = compiled(spring(1));
  for (const double b : {0.3, 1., 2., 4.4}) {
    // the quadrature's error is 2 sin(b / 2) (1 - b^2 / 12) - b cos(b / 2), and accelerations change by 2
    // sin(b / 2), both times the sine at the step's middle, which is close to 1 in some of the thousand steps
    const double change = b * 2 * std::abs(std::sin(b / 2));
    const double left = std::abs(b * std::cos(b / 2) - 2 * std::sin(b / 2) * (1 - b * b / 12)) / b;
    for (const auto& [order, part] : {std::pair(2, std::max(change / 12, left)),
                                      {4, std::max(change * change / 720, left)},
                                      {6, std::max(std::pow(change, 3) / 100800, left)}})
      EXPECT_NEAR(found_of_a_swing(system, b, order), part, 3e-3 * part) << b << ", order " << order;
  }
  // the limit of order 2 is about eight steps per swing (not exactly eight, which would repeat eight phases)
  EXPECT_NEAR(found_of_a_swing(system, pi / 4.001, 2), StepWatch::limit, 0.002);
}

TEST(StepWatch, MeasureOfABallFallsWithTheFourthPower) {
  // a free body with three different moments, integrated to 1e-13, so that only the quadrature's error
  // remains
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {3, 0.5, 4})},
                        {inertial(1, {0, 0, 0}, {1, 1.4, 2})})};
  const System system = compiled(scene);
  const auto part = [&](double step) {
    SimulationSettings how = settings("dop853", 4, 0.001, 1e-13);
    how.output_interval = step;
    const Trajectory path = run(system, how);
    StepWatch watch(system);
    for (Eigen::Index i = 0; i < path.q.rows(); ++i)
      watch.observe({path.times[i], path.q.row(i).transpose(), path.v.row(i).transpose()},
                    path.a.row(i).transpose(), true);
    return watch.worst(4).part;
  };
  EXPECT_NEAR(order(part(0.02), part(0.01)), 4, 0.1);
  EXPECT_LT(part(0.01), 1e-6);
}

TEST(StepWatch, DistrustsStepsNearThePeriodWithEveryMethod) {
  const System system = compiled(second_pendulum());
  for (const std::string& method : fixed_methods())
    for (const double step : {0.7, 0.97, 1.0, 1.4}) {
      SimulationSettings how = settings(method, 28, step);
      how.output_interval = 0;
      const Result<Trajectory> out = simulate(system, system.initial, how);
      if (out) {
        EXPECT_FALSE(out->certificate.trusted) << method << " at " << step;
      }
    }
}

TEST(StepWatch, FindsErrorsThatEnergyDoesNotShow) {
  // the implicit midpoint rule keeps the energy of a spring exactly, whatever the step
  SimulationSettings how = settings("implicit_midpoint", 1, 0.05);
  how.output_interval = 0;
  const Trajectory path = run(spring(1e4), how);
  const Certificate& c = path.certificate;
  EXPECT_LT(c.energy_drift, 1e-9 * c.energy_turnover);
  EXPECT_FALSE(c.trusted);
  EXPECT_NE(c.reason.find("do not follow the motion of coordinate 'x' of 'mass': the one up to t = "),
            std::string::npos)
      << c.reason;
  // b = w h = 5; the numerical angle per step is 2 atan(b / 2), and the defect h (a1 - a0) / 12
  const double most = 5 * 2 * std::sin(std::atan(2.5)) / 12;
  EXPECT_LT(c.step_defect, most * 1.01);  // the largest speed is taken at steps' ends
  EXPECT_GT(c.step_defect, 0.9 * most);
  EXPECT_EQ(c.step_defect_coordinate, "x");
  EXPECT_GT(c.reason_time, 0);
  EXPECT_EQ(c.reason_time, c.step_defect_time);
}

TEST(StepWatch, DistrustsGaussMethodsThatOnlyKeepEnergy) {
  // 5 radians per step, and 500, at which methods with an even number of stages hardly move
  for (const char* method : {"implicit_midpoint", "gauss4", "gauss6"})
    for (const double step : {0.05, 5.}) {
      const Certificate c = run(spring(1e4), settings(method, 20 * step, step)).certificate;
      EXPECT_FALSE(c.trusted) << method << " at " << step;
      EXPECT_NE(c.reason.find("do not follow the motion"), std::string::npos) << c.reason;
    }
}

TEST(StepWatch, TrustSeparatesRightFromWrongRuns) {
  // a spring over ten swings of 2 pi: the steps' defects add up to the lag behind cos(w t)
  for (const char* method : {"implicit_midpoint", "verlet", "gauss4", "gauss6", "generalized_alpha"})
    for (const double per_swing : {2.5, 4., 6., 8., 12., 20., 50.}) {
      SimulationSettings how = settings(method, 10, 1 / per_swing);
      how.energy_threshold = 1e9;  // energy is not judged here
      how.spectral_radius = 1;
      const System system = compiled(spring(4 * pi * pi));
      const Result<Trajectory> out = simulate(system, system.initial, how);
      if (!out) continue;  // diverged
      const Trajectory& path = *out;
      const double lag =
          std::abs(std::arg(std::complex<double>(last(path.q)[0], -last(path.v)[0] / (2 * pi))));
      const Certificate& c = path.certificate;
      if (c.trusted) {
        EXPECT_LT(lag, 20 * pi * 1.1 * StepWatch::limit) << method << ", " << per_swing;
      }
      if (per_swing >= 12) {
        EXPECT_TRUE(c.trusted) << method << ", " << per_swing << ": " << c.reason;
      }
      if (per_swing < 6 && c.trusted) {
        EXPECT_TRUE(std::string(method).starts_with("gauss")) << method << ", " << per_swing;
      }
    }
}

TEST(StepWatch, DistrustsStepsOfWholeTurns) {
  // a force that turns with a solid, x = (1 - cos(w t)) / w^2: after whole turns it seems constant
  constexpr double w = 100;
  const auto turned = [](Switch turn, double inertia, bool pushed) {
    Scene scene;
    scene.gravity.setZero();
    scene.solids = {solid("disc", "world", {slide("x", Vector3d::UnitX()), std::move(turn)},
                          {inertial(1, {0, 0, 0}, Vector3d::Constant(inertia))})};
    if (pushed) scene.efforts = {{"push", Force{{"disc", {0, 0, 0}}, {1, 0, 0}, Axes::solid}}};
    return scene;
  };
  for (const std::string& method : fixed_methods())
    for (const double turns : {1., 2., 2.1, 8.})
      for (const double inertia : {1e-6, 0.4})
        for (const bool pushed : {true, false}) {
          SimulationSettings how = settings(method, 10, 2 * pi * turns / w);
          how.output_interval = 0;
          const System system = compiled(turned(hinge("turn", Vector3d::UnitZ(), 0, w), inertia, pushed));
          const Result<Trajectory> out = simulate(system, system.initial, how);
          ASSERT_TRUE(out) << method << ": " << out.error().message();
          EXPECT_EQ(out->certificate.trusted, !pushed)
              << method << ", " << turns << ", " << inertia << ": " << out->certificate.reason;
        }
  for (const bool pushed : {true, false}) {
    const Certificate c = run(turned(ball("turn", identity_quaternion(), {0, 0, w}), 0.4, pushed),
                              settings("rk4", 10, 1.5 * pi / w))
                              .certificate;
    EXPECT_EQ(c.trusted, !pushed) << c.reason;
  }
}

TEST(StepWatch, IgnoresStiffCoordinatesThatDoNotSwing) {
  // a solid swings slowly on a stiff spring that bears its pull from the start: a step is 100 radians of the
  // spring's motion and 0.06 of the swing
  Scene scene = second_pendulum();
  scene.solids[0].switches.insert(scene.solids[0].switches.begin(),
                                  slide("give", Vector3d::UnitZ(), -9.81 * std::pow(std::cos(0.2), 2) / 1e8));
  scene.efforts = {{"stiff", CoordinateSpring{{"give"}, 1e8, 0, 0}}};
  SimulationSettings how = settings("implicit_midpoint", 4, 0.01);
  const Certificate c = run(scene, how).certificate;
  EXPECT_TRUE(c.trusted) << c.reason;
  // a rotation of three radians per step about a principal axis
  Scene top;
  top.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {0, 0, 300})},
                      {inertial(1, {0, 0, 0}, {1, 1, 1.5})})};
  const Certificate steady = run(top, settings("rk4", 1, 0.01)).certificate;
  EXPECT_TRUE(steady.trusted) << steady.reason;
  EXPECT_LT(steady.step_defect, 1e-9);
}

TEST(StepWatch, HeavyNeighbourDoesNotHideASwing) {
  Scene scene = spring(1e4, 1e-3);
  scene.gravity = {0, 0, -9.81};
  scene.solids.push_back(
      solid("weight", "world", {slide("fall", Vector3d::UnitZ())}, {inertial(1000, {0, 0, 0}, {1, 1, 1})}));
  const Certificate c = run(scene, settings("implicit_midpoint", 5, 0.05)).certificate;
  EXPECT_FALSE(c.trusted);
  EXPECT_EQ(c.step_defect_coordinate, "x");
}

TEST(StepWatch, IgnoresImpacts) {
  // a stone that rebounds ten times: velocities jump at events, where steps end
  Scene scene;
  scene.solids = {
      solid("stone", "world", {slide("z", Vector3d::UnitZ(), 1)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  Limit floor;
  floor.on = {"z"};
  floor.lower = 0;
  floor.restitution = 0.9;
  scene.constraints = {{"floor", floor}};
  const Certificate c = run(scene, settings("rk4", 5, 0.01)).certificate;
  EXPECT_GT(c.impacts, 5);
  EXPECT_TRUE(c.trusted) << c.reason;
  EXPECT_LT(c.step_defect, 1e-9);
}

}  // namespace
}  // namespace borelli::test::step_watch_test
