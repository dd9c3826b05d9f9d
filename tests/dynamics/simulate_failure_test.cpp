// Runs that fail, and settings that are refused, name what is wrong and where.
#include "dynamics/run/simulate.hpp"

#include <cmath>

#include "scenes.hpp"

namespace borelli::test::simulate_failure_test {
namespace {

void expect_failure(const Scene& scene, const SimulationSettings& how, const std::string& where,
                    const std::string& what) {
  const System system = compiled(scene);
  const Result<Trajectory> out = simulate(system, system.initial, how);
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().where, where);
  EXPECT_NE(out.error().what.find(what), std::string::npos) << out.error().what;
}

TEST(Failure, DivergenceUnderAFixedStepNamesItsTime) {
  Scene scene = chain(1, false, 0.1);
  scene.efforts = {{"stiff", CoordinateSpring{{"h0"}, 1e8, 0, 0}}};
  expect_failure(scene, settings("rk4", 10, 0.01), "coordinate 'h0'", "; the run ends at t = 0.");
}

TEST(Failure, DivergenceNamesCoordinateOrVelocity) {
  // a point on a circle: a step of 1 s throws it far away, and projection back to the circle leaves no
  // velocity
  Scene scene = read_scene(source_folder() + "/samples/a01.toml").value();
  const System system = compiled(scene);
  const Result<Trajectory> leap = simulate(system, system.initial, settings("rk4", 10, 1));
  ASSERT_FALSE(leap);
  EXPECT_NE(leap.error().what.find("it has grown to "), std::string::npos) << leap.error().what;
  EXPECT_EQ(leap.error().what.find("velocity"), std::string::npos) << leap.error().what;
  const Result<Trajectory> fast = simulate(system, system.initial, settings("rk4", 10, 2));
  ASSERT_FALSE(fast);
  EXPECT_NE(fast.error().what.find("its velocity has grown to -"), std::string::npos) << fast.error().what;
}

TEST(Failure, VanishingStepNamesTheCoordinate) {
  // a force that becomes infinite at t = 1 s, when the motion reaches a point
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), 1, -1)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  FunctionConstraint wall;
  wall.points = {{"mass", {0, 0, 0}}};
  wall.function = [](double t, const Eigen::VectorXd& x, FunctionDerivatives& f) {
    const double s = std::sqrt(x[0]);
    f.value = s - (1 - t);
    f.gradient[0] = 0.5 / s;
    f.hessian(0, 0) = -0.25 / (s * x[0]);
    f.rate = 1;
  };
  scene.constraints = {{"wall", wall}};
  const System system = compiled(scene);
  const Result<Trajectory> out = simulate(system, system.initial, settings("rk4_adaptive", 2, 0.01, 1e-9));
  ASSERT_FALSE(out);
  EXPECT_NE(out.error().what.find("t = "), std::string::npos) << out.error().what;
}

TEST(Failure, InvalidSettingsAreRefused) {
  const Scene scene = chain(1, false);
  expect_failure(scene, settings("rk5", 1, 0.01), "method 'rk5'", "choose from euler");
  expect_failure(scene, settings("rk4", 1, 0), "simulation, step", "is 0; expected a positive time");
  expect_failure(scene, settings("rk4", -1, 0.1), "simulation, end_time", "is -1");
  expect_failure(scene, settings("rk4_adaptive", 1, 0.1, 0), "simulation, tolerance", "is 0");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [member, name] : {std::pair(&SimulationSettings::end_time, "end_time"),
                                     {&SimulationSettings::step, "step"},
                                     {&SimulationSettings::tolerance, "tolerance"},
                                     {&SimulationSettings::accuracy, "accuracy"},
                                     {&SimulationSettings::spectral_radius, "spectral_radius"},
                                     {&SimulationSettings::output_interval, "output_interval"},
                                     {&SimulationSettings::baumgarte_alpha, "baumgarte_alpha"},
                                     {&SimulationSettings::baumgarte_beta, "baumgarte_beta"},
                                     {&SimulationSettings::energy_threshold, "energy_threshold"},
                                     {&SimulationSettings::rest_speed, "rest_speed"}})
    for (const double wrong : {nan, -1., -std::numeric_limits<double>::infinity()}) {
      SimulationSettings how = settings("rk4_adaptive", 1, 0.1);
      how.*member = wrong;
      expect_failure(scene, how, fmt::format("simulation, {}", name), fmt::format("is {}", wrong));
    }
}

TEST(Failure, TooManyStepsOrRowsAreRefused) {
  const Scene scene = chain(1, false, 0.5);
  expect_failure(scene, settings("rk4", 1, 1e-20), "simulation, step",
                 "makes 1e+20 steps up to the end_time; expected at most 1e+09");
  SimulationSettings how = settings("rk4_adaptive", 1, 0.01);
  how.output_interval = 1e-20;
  expect_failure(scene, how, "simulation, output_interval", "1e+20 rows of output");
  how = settings("rk4", 1e300, 0.01);
  expect_failure(scene, how, "simulation, step", "makes 1e+302 steps");
  how = settings("rk4", 1, 1e-8);
  how.output_interval = 0;  // every step is a row
  expect_failure(scene, how, "simulation, step", "1e+08 rows of output");
  Scene hum = scene;
  hum.efforts = {{"hum", Force{{"l0", {0, 0, 0}}, {1, 0, 0}, Axes::world, Sine{1, 1e12, 0, 0}, {}}}};
  expect_failure(hum, settings("rk4_adaptive", 1, 0.01), "effort 'hum'", "expected at most 1e+09");
}

TEST(Failure, ReportsAThrowingUserFunction) {
  Scene scene = chain(1, false);
  FunctionConstraint own;
  own.coordinates = {{"h0"}};
  own.function = [](double, const Eigen::VectorXd&, FunctionDerivatives&) {
    throw std::runtime_error("no table");
  };
  scene.constraints = {{"own", own}};
  expect_failure(scene, settings("rk4", 1, 0.1), "chain of 1", "a user's function threw: no table");
  own.function = [](double, const Eigen::VectorXd&, FunctionDerivatives&) { throw 7; };
  scene.constraints = {{"own", own}};
  expect_failure(scene, settings("rk4", 1, 0.1), "chain of 1",
                 "a user's function threw something other than a std::exception");
  own.function = [](double, const Eigen::VectorXd&, FunctionDerivatives&) { throw std::bad_alloc(); };
  scene.constraints = {{"own", own}};
  expect_failure(scene, settings("rk4", 1, 0.1), "chain of 1",
                 "not enough memory for 1 coordinates, 1 constraint rows and 0 contacts");
}

}  // namespace
}  // namespace borelli::test::simulate_failure_test
