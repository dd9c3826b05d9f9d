// Scaled models: trials made from models of known sizes, and OpenSim's static trial.
#include "pipeline/motion/static_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "pipeline/motion/scaled_scene.hpp"
#include "pipeline/recordings/recording.hpp"
#include "tests/paths.hpp"

namespace borelli::test::static_fit_test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

Scene gait() { return need(read_model(shared_folder() + "/motion/gait10dof/subject01.osim")).scene; }

MarkerMotion trial_of(const Scene& scene, const std::vector<double>& q) {
  const System system = need(compile(scene));
  State state = system.initial;
  for (Eigen::Index i = 0; i < state.q.size(); ++i) state.q[i] = q[std::size_t(i) % q.size()];
  MarkerMotion out{{}, {0}, {Matrix3Xd(3, Eigen::Index(scene.markers.size()))}, {}};
  for (std::size_t m = 0; m < scene.markers.size(); ++m) {
    out.names.push_back(scene.markers[m].name);
    out.frames[0].col(Eigen::Index(m)) = need(point_motion(system, state, scene.markers[m].at)).position;
  }
  return out;
}

TEST(ScaledScene, OneFactorScalesPlacesMassesAndTensors) {
  const Scene scene = gait();
  const double s = 1.1;
  const Scene larger = scaled(scene, std::vector<double>(scene.solids.size(), s)).scene;
  EXPECT_NEAR(need(total_mass(larger)), s * s * s * need(total_mass(scene)), 1e-9);
  // distances between markers grow by s
  const Matrix3Xd before = trial_of(scene, {0}).frames[0], after = trial_of(larger, {0}).frames[0];
  for (Eigen::Index m = 1; m < before.cols(); ++m)
    EXPECT_NEAR((after.col(m) - after.col(0)).norm(), s * (before.col(m) - before.col(0)).norm(), 1e-12);
  // a similar body under the same gravity swings slower by sqrt(s): accelerations of angles scale with 1/s
  const System small = need(compile(scene)), large = need(compile(larger));
  State state = small.initial, larger_state = large.initial;
  state.v.setZero();
  larger_state.v.setZero();
  const Eigen::VectorXd a = need(evaluate(small, state)).acceleration,
                        b = need(evaluate(large, larger_state)).acceleration;
  for (const CoordinateInfo& c : small.coordinates)
    EXPECT_NEAR(b[c.v_index], c.angle ? a[c.v_index] / s : a[c.v_index], 1e-9) << c.name;
}

TEST(ScaledScene, MassFactorMayUndoTheCube) {
  const Scene scene = gait();
  const Scene larger = scaled(scene, std::vector<double>(scene.solids.size(), 1.2), std::pow(1.2, -3)).scene;
  EXPECT_NEAR(need(total_mass(larger)), need(total_mass(scene)), 1e-12);
  EXPECT_NEAR(larger.solids[0].inertials[0].tensor(0, 0), 1.44 * scene.solids[0].inertials[0].tensor(0, 0),
              1e-12);
}

TEST(StaticFit, FindsOneFactorOfTheWholeBody) {
  const Scene scene = gait();
  const MarkerMotion trial =
      trial_of(scaled(scene, std::vector<double>(scene.solids.size(), 0.93)).scene, {0.1, 0.2, 0.05});
  StaticFitRequest request;
  request.per_segment = false;
  const StaticFit fit = need(fit_static(scene, trial, request));
  for (double factor : fit.factors) EXPECT_NEAR(factor, 0.93, 1e-5);
  EXPECT_LT(fit.rms_after, 1e-5);
  EXPECT_GT(fit.rms_before, 0.01);
}

TEST(StaticFit, FindsTheFactorsOfSegments) {
  const Scene scene = gait();
  std::vector<double> factors;
  for (const Solid& solid : scene.solids)
    factors.push_back(solid.name.starts_with("tibia") ? 1.06 : solid.name.starts_with("femur") ? 0.97 : 1.0);
  StaticFitRequest request;
  request.per_segment = true;
  const StaticFit fit = need(fit_static(scene, trial_of(scaled(scene, factors).scene, {0.1}), request));
  for (std::size_t i = 0; i < factors.size(); ++i)
    if (scene.solids[i].name.starts_with("tibia") || scene.solids[i].name.starts_with("femur")) {
      // the prior of 10 % moves a factor by a few thousandths if markers hardly determine it
      EXPECT_NEAR(fit.factors[i], factors[i], 0.02) << scene.solids[i].name;
    }
  EXPECT_LT(fit.rms_after, 0.002);
}

// The start is the trial's pose; a coupled coordinate has none of its own.
TEST(StaticFit, KeepsCouplings) {
  const Scene scene = need(parse_scene(R"(
[[solid]]
name = "arm"
joint = {rotation = "y", name = "shoulder"}
mass = 1
centre = [0, 0, -0.5]
tensor = [1, 1, 1]
[[solid]]
name = "hand"
parent = "arm"
joint = [{translation = "z", value = -1, locked = true},
  {rotation = "y", name = "wrist", coupled = {to = "shoulder", function = [0, 0.5]}}]
mass = 1
tensor = [1, 1, 1]
[[marker]]
name = "a"
solid = "arm"
point = [0.2, 0, -0.4]
[[marker]]
name = "b"
solid = "arm"
point = [0, 0.3, -0.8]
[[marker]]
name = "c"
solid = "hand"
point = [0.1, 0, -0.3]
)",
                                       "arm.toml"));
  const StaticFit fit = need(fit_static(scene, trial_of(scene, {0.4, 0.2}), {}));
  const System system = need(compile(fit.scene));
  for (const CoordinateInfo& c : system.coordinates)
    EXPECT_NEAR(system.initial.q[c.q_index], c.name == "wrist" ? 0.2 : 0.4, 1e-6) << c.name;
}

TEST(StaticFit, PutsTheMarkersWhereTheTrialShowsThem) {
  const Scene scene = gait();
  const Recording trial = need(read_recording(shared_folder() + "/motion/gait10dof/subject01_static.trc"));
  // one factor: this model moves in a plane, and separate factors would stretch segments to reach the feet,
  // which stand apart
  StaticFitRequest request;
  request.mass = 72.6;
  request.per_segment = false;
  const StaticFit fit = need(fit_static(scene, trial.markers, request));
  EXPECT_LT(fit.rms_after, fit.rms_before);
  EXPECT_NEAR(need(total_mass(fit.scene)), 72.6, 1e-9);
  // the model already fits this person
  for (std::size_t i = 0; i < fit.factors.size(); ++i)
    EXPECT_NEAR(fit.factors[i], 1, 0.12) << scene.solids[i].name;
  const StaticFit again = need(fit_static(fit.scene, trial.markers, {}));
  EXPECT_LT(again.rms_before, 1e-6);
}

TEST(StaticFit, DoubtsSegmentsThatStretchForAPoseTheModelCannotTake) {
  const Scene scene = gait();
  const Recording trial = need(read_recording(shared_folder() + "/motion/gait10dof/subject01_static.trc"));
  StaticFitRequest request;
  request.per_segment = true;
  const StaticFit fit = need(fit_static(scene, trial.markers, request));
  bool doubted = false;
  for (const std::string& warning : fit.warnings) doubted |= warning.find("pelvis 1.3") != std::string::npos;
  EXPECT_TRUE(doubted);
}

TEST(StaticFit, RefusesATrialWithTooFewMarkers) {
  const Scene scene = gait();
  MarkerMotion trial = trial_of(scene, {0});
  trial.names.resize(2);
  trial.frames[0].conservativeResize(3, 2);
  EXPECT_FALSE(fit_static(scene, trial, {}));
}

}  // namespace
}  // namespace borelli::test::static_fit_test
