// Each sample scene does what its description says: against closed forms, published numbers and another
// program.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <tuple>

#include "scenes.hpp"
#include "tests/paths.hpp"

#ifdef BORELLI_MUJOCO
#include <mujoco/mujoco.h>
#endif

namespace borelli::test::samples_test {
namespace {

using Eigen::Vector3d;

double last(const Trajectory& t, int i) { return t.q(t.q.rows() - 1, i); }
double last_velocity(const Trajectory& t, int i) { return t.v(t.v.rows() - 1, i); }

// Each sample, run by its own settings, is trusted by its certificate.
TEST(Samples, AllRunAndAreTrusted) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_folder() + "/samples")) {
    if (entry.path().extension() != ".toml") continue;
    if (entry.path().filename() == "painleve_rod.toml") continue;  // has no motion; see contact_events_test
    SCOPED_TRACE(entry.path().filename());
    const Trajectory t = run(sample(entry.path().filename()));
    EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
    ++count;
  }
  EXPECT_GE(count, 18);
}

TEST(Samples, PendulumReturnsAfterItsPeriod) {
  // 4 K(sin 45 degrees) sqrt(l/g): IFToMM problem A01
  Scene scene = sample("pendulum.toml");
  scene.simulation.end_time = 2.36784194757623745;
  EXPECT_NEAR(4 * std::comp_ellint_1(std::sqrt(0.5)) / std::sqrt(9.81), scene.simulation.end_time, 1e-14);
  const Trajectory t = run(scene);
  // at rest there, a shift in time changes the angle by its square and the velocity by g/l times the shift;
  // adaptive RK4 at 1e-9 per step and about 200 steps per period adds up to 1e-7
  EXPECT_NEAR(last(t, 0), std::acos(0.), 1e-7);
  EXPECT_NEAR(last_velocity(t, 0), 0, 1e-7);
}

TEST(Samples, PendulumMatchesTheBenchmark) {
  const Trajectory t = run(sample("pendulum.toml"));
  const Vector3d bob = t.gravity_centre.bottomRows(1).transpose();
  // IFToMM A01: P(10) = (-.275087462576117, -.961419205099125), let go on the other side of the pivot
  EXPECT_NEAR(std::abs(bob.x()), 0.275087462576117,
              1e-6);  // ten seconds at a tolerance of 1e-9 a step, 800 steps
  EXPECT_NEAR(bob.z(), -0.961419205099125, 1e-6);
}

TEST(Samples, WindowsMatchTheBenchmark) {
  // IFToMM A02, N-four-bar: B0 after 10 s, N = 2 and 40; through ten singular positions
  const std::tuple<const char*, double, double> ends[] = {
      {"four_bar_2.toml", .328458111540815, .944518538178601},
      {"four_bar_40.toml", .180512226686728, .983572740582312}};
  for (const auto& [name, x, z] : ends) {
    SCOPED_TRACE(name);
    const Trajectory t = run(sample(name));
    EXPECT_NEAR(std::cos(last(t, 0)), x, 1e-6);  // 110 to 180 steps at a tolerance of 1e-9 a step
    EXPECT_NEAR(std::sin(last(t, 0)), z, 1e-6);
    EXPECT_LT(t.certificate.energy_drift, 1e-6);
  }
}

TEST(Samples, HeavyTopMatchesTheLiterature) {
  const Trajectory t = run(sample("heavy_top.toml"));
  const Vector3d centre = t.gravity_centre.bottomRows(1).transpose();
  // Arnold & Bruels' heavy top at 2 s, published to eleven digits; 47 turns, 1190 steps at a tolerance of
  // 1e-11
  EXPECT_LT((centre - Vector3d(-0.15041682275, -0.72416559164, -0.67302226956)).norm(), 1e-8);
}

TEST(Samples, SpinningPlateFlipsAndKeepsItsMomentum) {
  const Trajectory t = run(sample("spinning_plate.toml"));
  const Vector3d moments(1, 2, 3);
  Vector3d first;
  double lowest = 10;
  for (Eigen::Index i = 0; i < t.v.rows(); ++i) {
    const Vector3d spin = t.v.row(i).tail(3).transpose();
    const Vector3d momentum = t.pose(static_cast<std::size_t>(i), 0).R * moments.cwiseProduct(spin);
    if (i == 0) first = momentum;
    EXPECT_LT((momentum - first).norm(), 1e-7);  // of 20 kg m^2/s; 1100 steps at 1e-9
    lowest = std::min(lowest, spin.y());
  }
  EXPECT_LT(lowest, -9.99);  // the middle axis has turned over
}

TEST(Samples, RoundaboutMatchesItsReference) {
  Scene scene = sample("roundabout.toml");
  scene.simulation.method = "rk4_adaptive";
  scene.simulation.tolerance = 1e-11;
  scene.simulation.step = 1e-4;
  const Trajectory t = run(scene);
  // 8 and more digits agree between two unlike methods of other programs
  const double q[] = {36.589803206456790, -0.491961391081574, 0.009149081659433};
  const double v[] = {7.73755291360600, 12.9839351301372, -9.92117999987793};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(last(t, i), q[i], 1e-7);
    EXPECT_NEAR(last_velocity(t, i), v[i], 1e-6);
  }
}

TEST(Samples, ShockIsSymmetricAndStopsAtTheBarsLength) {
  const Trajectory t = run(sample("shock.toml"));
  double lowest = 0;
  for (Eigen::Index i = 0; i < t.q.rows(); ++i) {
    // the slide holds the bar's far end at z = 0, so height = -cos(tilt): the residual computed independently
    EXPECT_NEAR(t.q(i, 0) + std::cos(t.q(i, 1)), 0, 1e-9);
    lowest = std::min(lowest, t.q(i, 0));
  }
  EXPECT_NEAR(lowest, -1, 1e-4);
  // until the bar whips round, the fall is nearly free: the bar has less than 1 % of m v^2 / 2 + I w^2 / 2
  const auto& c = t.certificate;
  EXPECT_NEAR(std::fmod(c.smallest_step_time, 2 * std::sqrt(2 / 9.81)), std::sqrt(2 / 9.81), 0.01);
}

// A motion of 10 s against MuJoCo with its own equations and its own Runge-Kutta steps.
TEST(Samples, DoublePendulumMatchesMuJoCo) {
  const Trajectory t = run(sample("double_pendulum.toml"));
  const double q[] = {0.805048150457940, -0.638326467639700}, v[] = {-1.53027089632793, 1.08898678404824};
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(last(t, i), q[i],
                2e-6);  // the sample's own tolerance: 1e-9 a step, 1200 steps, errors grow tenfold
    EXPECT_NEAR(last_velocity(t, i), v[i], 1e-5);
  }
#ifdef BORELLI_MUJOCO
  const auto path =
      std::filesystem::temp_directory_path() / ("borelli_pendulum_" + std::to_string(getpid()) + ".xml");
  std::ofstream(path) << R"(<mujoco><compiler angle="radian"/>
<option timestep="1e-4" integrator="RK4" gravity="0 0 -9.81"><flag contact="disable"/></option><worldbody><body>
<joint type="hinge" axis="0 1 0"/><inertial pos="0 0 -.5" mass="1" diaginertia=".08333333333333333 .08333333333333333 .001"/>
<body pos="0 0 -1"><joint type="hinge" axis="1 0 0"/>
<inertial pos="0 0 -.5" mass="1" diaginertia=".08333333333333333 .08333333333333333 .001"/></body></body></worldbody></mujoco>)";
  char error[500] = "";
  mjModel* model = mj_loadXML(path.c_str(), nullptr, error, sizeof error);
  std::filesystem::remove(path);
  ASSERT_TRUE(model) << error;
  mjData* data = mj_makeData(model);
  data->qpos[0] = 1, data->qpos[1] = 0.7;
  for (int i = 0; i < 100000; ++i) mj_step(model, data);
  Scene scene = sample("double_pendulum.toml");
  scene.simulation.tolerance = 1e-12;
  const Trajectory fine = run(scene);
  for (int i = 0; i < 2; ++i) {
    // both of fourth order: 1e5 steps of 1e-4 s, (1e-4)^4 a second with a factor of hundreds, and
    // rounding
    EXPECT_NEAR(last(fine, i), data->qpos[i], 1e-9);
    EXPECT_NEAR(last_velocity(fine, i), data->qvel[i], 1e-8);
  }
  mj_deleteData(data);
  mj_deleteModel(model);
#endif
}

}  // namespace
}  // namespace borelli::test::samples_test
