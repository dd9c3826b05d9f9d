// Runs to a given accuracy whose steps functions of time limit more than the tolerance does. Two runs at
// different tolerances then take the same steps, so their difference does not show the error.
#include <cmath>

#include "scenes.hpp"
#include "to_accuracy.hpp"

namespace borelli::test::accuracy_in_time_test {
namespace {

// z'' + w0^2 z = force sin(w t) from z = 1 at rest.
struct PushedOscillator {
  double w0, w, force;

  double z(double t) const {
    return std::cos(w0 * t) + start() * std::sin(w0 * t) + forced() * std::sin(w * t);
  }
  double rate(double t) const {
    return w0 * (start() * std::cos(w0 * t) - std::sin(w0 * t)) + forced() * w * std::cos(w * t);
  }

 private:
  double forced() const { return force / (w0 * w0 - w * w); }
  double start() const { return -forced() * w / w0; }
};

Scene scene_of(const PushedOscillator& o, const TimeFunction& factor) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("m", "world", {slide("z", Vector3d::UnitZ(), 1)}, {inertial(1, {0, 0, 0}, {.01, .01, .01})})};
  scene.efforts = {{"spring", CoordinateSpring{{"z"}, o.w0 * o.w0, 0, 0}},
                   {"push", Force{{"m", {0, 0, 0}}, {0, 0, 1}, Axes::world, factor}}};
  return scene;
}

// The error at the run's end, on the scale of accuracies.
double error_of(const System& system, const Trajectory& run, const PushedOscillator& o) {
  const double end = run.times.back(), unit = system.velocity_scale[0];
  const double q = run.q.bottomRows(1)(0, 0), v = run.v.bottomRows(1)(0, 0);
  return std::max(std::abs(q - o.z(end)) / std::max(unit, std::abs(q)),
                  std::abs(v - o.rate(end)) / (unit + std::abs(v)));
}

TEST(AccuracyInTime, IsStatedRight) {
  constexpr double end = 400;
  Table zeros;
  for (double t = 0; t < end + 1; t += 0.1) zeros.times.push_back(t), zeros.values.push_back(0);
  zeros.prepare();
  const PushedOscillator pushed{20, 25, 1e-3}, free{20, 25, 0};
  const TimeFunction sine = Sine{pushed.force, pushed.w, 0, 0}, table = zeros;
  for (const auto& [oscillator, factor, accuracy, verify] : {std::tuple{pushed, sine, 1e-5, false},
                                                             {pushed, sine, 1e-7, false},
                                                             {pushed, sine, 1e-5, true},
                                                             {free, table, 1e-5, false},
                                                             {free, table, 1e-5, true}}) {
    SCOPED_TRACE(fmt::format("to {}, {}{}", accuracy, oscillator.force == 0 ? "table" : "sine",
                             verify ? ", verified" : ""));
    const System system = compiled(scene_of(oscillator, factor));
    const Trajectory run = need(simulate(system, system.initial, to_accuracy(end, accuracy, verify)));
    const double error = error_of(system, run, oscillator);
    EXPECT_TRUE(run.certificate.trusted) << run.certificate.reason;
    EXPECT_LE(error, accuracy);
    // the estimate stems from times between which the error oscillates
    EXPECT_LE(error, 2 * run.certificate.estimated_error) << notes_of(run.certificate);
  }
}

// A stiff, damped spring beside it makes the program choose an implicit method.
TEST(AccuracyInTime, IsStatedRightForImplicitMethods) {
  constexpr double end = 20;
  for (const double w : {25., 0.1})
    for (const double accuracy : {1e-3, 1e-5, 1e-7}) {
      SCOPED_TRACE(fmt::format("w = {}, to {}", w, accuracy));
      const PushedOscillator oscillator{20, w, 1};
      Scene scene = scene_of(oscillator, Sine{1, w, 0, 0});
      scene.solids.push_back(
          solid("stiff", "world", {slide("x", Vector3d::UnitX(), 1)}, {inertial(1, {0, 0, 0}, {1, 1, 1})}));
      scene.efforts.push_back({"damper", CoordinateSpring{{"x"}, 1e6, 1e4, 0}});
      const System system = compiled(scene);
      const Trajectory run = need(simulate(system, system.initial, to_accuracy(end, accuracy)));
      EXPECT_EQ(run.certificate.method, "cvode");
      const double error = error_of(system, run, oscillator);
      EXPECT_TRUE(run.certificate.trusted) << run.certificate.reason;
      EXPECT_LE(error, accuracy);
      // errors of multistep methods are only about proportional to tolerances
      EXPECT_LE(error, 4 * run.certificate.estimated_error) << notes_of(run.certificate);
    }
}

}  // namespace
}  // namespace borelli::test::accuracy_in_time_test
