// The reference of a chart: how long the motion can be compared, and what stands against a reference.
#include "pipeline/charts/work_precision_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/work_precision_made.hpp"

namespace borelli::work_precision_test {
namespace {

TEST(WorkPrecision, ComparesNothingBeyondChaos) {
  Scene scene = read_scene(test::source_folder() + "/samples/pendulum_5.toml").value();
  scene.simulation.end_time = 40;
  const WorkPrecision chart = work_precision(scene, measured_once({"dop853"})).value();
  ASSERT_TRUE(chart.reference.found);
  EXPECT_LT(chart.reference.horizon, 40);
  EXPECT_NE(chart.reference.words.find("as in chaos"), std::string::npos) << chart.reference.words;
  // up to the horizon, fine runs agree with the reference
  double best = 1;
  for (const WorkPrecisionPoint& p : chart.points) best = std::min(best, p.errors.position);
  EXPECT_LT(best, 1e-6);
}

TEST(WorkPrecision, EarlyDivergenceMovesTheOutputs) {
  Scene scene = read_scene(test::source_folder() + "/samples/pendulum_5.toml").value();
  WorkPrecisionSettings settings = measured_once({"dop853"});
  for (const double end : {200., 600.}) {  // one or two outputs remain, or none
    scene.simulation.end_time = end;
    settings.outputs = 10, settings.budget = 0.05;
    const WorkPrecision chart = work_precision(scene, settings).value();
    ASSERT_TRUE(chart.reference.found) << chart.reference.words;
    EXPECT_NE(chart.reference.words.find("diverge too early, as in chaos"), std::string::npos)
        << chart.reference.words;
    EXPECT_LT(chart.reference.horizon, 60);
    EXPECT_NEAR(chart.duration, chart.reference.horizon, 1e-9);
    // steps are as long as the time between outputs, and all outputs are compared
    EXPECT_TRUE(fastest_within(chart, 1e-3)) << chart.reference.words;
  }
}

// A swing for a thousand periods: the difference of two methods grows as the square of time, which is not
// chaos, so the whole motion is compared.
TEST(WorkPrecision, LongSwingIsNotChaos) {
  Scene scene = read_scene(test::source_folder() + "/samples/pendulum.toml").value();
  scene.simulation.end_time = 3000;
  const WorkPrecision chart = work_precision(scene, measured_once({"dop853"})).value();
  ASSERT_TRUE(chart.reference.found);
  EXPECT_EQ(chart.reference.words.find("chaos"), std::string::npos) << chart.reference.words;
  EXPECT_NEAR(chart.reference.horizon, 3000, 1e-6) << chart.reference.words;
  EXPECT_TRUE(fastest_within(chart, 1e-3));
}

// Near the separatrix each turn of the plate multiplies the difference of two runs, to 5e-6 after 10 s. Over
// half of that time, accuracies down to 1e-7 can be judged.
TEST(WorkPrecision, GrowingDivergenceShortensTheComparison) {
  const Scene scene = read_scene(test::source_folder() + "/samples/spinning_plate.toml").value();
  const WorkPrecision chart = work_precision(scene, measured_once({"dop853"})).value();
  ASSERT_TRUE(chart.reference.found);
  EXPECT_LE(reference_floor(chart), 1e-7) << chart.reference.words;
  EXPECT_GT(chart.reference.horizon, 3) << chart.reference.words;  // it has turned over twice
  EXPECT_LT(chart.reference.horizon, 9) << chart.reference.words;
  EXPECT_TRUE(fastest_within(chart, 1e-6));
}

// Springs of 3e8 N m/rad with dampers of 5e6: no explicit method succeeds. The stiff spring's angle is
// bounded by its load over its stiffness.
TEST(WorkPrecision, StiffSceneHasAnImplicitReference) {
  const Scene scene = parse_scene(R"(name = "very stiff arm"
gravity = [0, 0, -9.81]
[simulation]
end_time = 2
[[solid]]
name = "upper"
joint = {rotation = "y", name = "q1", value = 0.1}
mass = 2.0
centre = [0, 0, -0.15]
tensor = [0.02, 0.02, 0.001]
[[solid]]
name = "fore"
parent = "upper"
joint = [{fixed = [0, 0, -0.3]}, {rotation = "y", name = "q2", value = 0.9}]
mass = 1.2
centre = [0, 0, -0.14]
tensor = [0.01, 0.01, 0.001]
[[effort]]
name = "k1"
kind = "coordinate_spring"
on = "q1"
stiffness = 3e8
damping = 5e6
rest = 0.1
)",
                                  "arm.toml")
                          .value();
  const WorkPrecision chart = work_precision(scene, measured_once({"cvode", "gauss6"})).value();
  ASSERT_TRUE(chart.reference.found) << chart.reference.words;
  EXPECT_NE(chart.reference.runs[0].find("cvode"), std::string::npos);
  EXPECT_NEAR(chart.reference.horizon, 2, 1e-9);
  EXPECT_TRUE(fastest_within(chart, 1e-6));
  // the same scene with a rigid joint moves as a pendulum; the spring yields by less than 1e-7
  Scene rigid = scene;
  rigid.efforts.clear();
  rigid.solids[0].switches[0].motion = Locked{};
  const System one = compile(rigid).value(), two = compile(scene).value();
  SimulationSettings how = rigid.simulation;
  how.method = "dop853";
  how.tolerance = 1e-12;
  how.output_interval = 0.1;
  const Trajectory pendulum = simulate(one, one.initial, how).value();
  how.method = "cvode";
  how.tolerance = 1e-11;
  const Trajectory stiff = simulate(two, two.initial, how).value();
  for (std::size_t row = 0; row < pendulum.times.size(); ++row)
    EXPECT_NEAR(stiff.q(Eigen::Index(row), 1), pendulum.q(Eigen::Index(row), 0), 1e-6);
}

TEST(WorkPrecision, SaysIfNoMethodCompletesTheRun) {
  Scene scene = oscillator();
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, -1e6, 0, 0}}};  // runs away as exp(1000 t)
  WorkPrecisionSettings settings;
  settings.methods = {"rk4"};
  settings.repeats = 1;
  const WorkPrecision chart = work_precision(scene, settings).value();
  EXPECT_FALSE(chart.reference.found);
  EXPECT_NE(chart.reference.words.find("no method completes the run"), std::string::npos)
      << chart.reference.words;
}

// A reference said to be exact to 1e-12 but 0.1 m off; two of our methods contradict it.
TEST(WorkPrecision, ContradictsAWrongReference) {
  const Scene scene = oscillator();
  WorkPrecisionSettings settings = measured_once({"rk4"}, 0.02);
  const auto words = [&](double off) {
    GivenReference given{.name = "mine.csv", .times = {}, .poses = {}};
    for (int i = 0; i <= settings.outputs; ++i) {
      given.times.push_back(5. * i / settings.outputs);
      given.poses.push_back({.p = {std::cos(2 * given.times.back()) + off, 0, 0}});
    }
    settings.reference = given;
    return work_precision(scene, settings).value().reference.words;
  };
  EXPECT_NE(words(0.1).find("It is contradicted"), std::string::npos) << words(0.1);
  EXPECT_EQ(words(0).find("contradicted"), std::string::npos) << words(0);
  EXPECT_NE(words(0).find("agree with it to"), std::string::npos) << words(0);
}

}  // namespace
}  // namespace borelli::work_precision_test
