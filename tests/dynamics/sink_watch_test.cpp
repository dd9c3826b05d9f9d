// A run is stopped with a reason if its steps shrink to nothing, but not at a jump of a force.
#include "dynamics/run/sink_watch.hpp"

#include "dynamics/methods/integrator.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

using Verdict = SinkWatch::Verdict;

TEST(SinkWatch, ReportsSteadilyShrinkingSteps) {
  SinkWatch watch;
  double t = 0, step = 0.1;
  int steps = 0;
  while (watch.after(t, step, true, 10, 1e9) == Verdict::fine && ++steps < 1000) t += step, step *= 0.5;
  EXPECT_EQ(steps, 40);  // 2^-40 is the first below 1e-12, long after 16 below 1e-6
}

TEST(SinkWatch, IgnoresATemporaryDip) {
  // as at a jump of a force: rejections down to 1e-14 of the step, then growth
  SinkWatch watch;
  double t = 0;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(watch.after(t += 0.1, 0.1, true, 10, 1e9), Verdict::fine);
  for (double step = 0.02; step > 1e-15; step *= 0.2)
    EXPECT_EQ(watch.after(t, step, false, 10, 1e9), Verdict::fine);
  for (double step = 1e-15; step < 0.1; step *= 4)
    EXPECT_EQ(watch.after(t += step, step, true, 10, 1e9), Verdict::fine);
}

TEST(SinkWatch, ReportsTinySteps) {
  // after 2000 steps of 1e-11 s, 10 s still need 1e12 steps, more than ten times 1e9
  for (const auto& [step, verdict] : {std::pair(1e-11, Verdict::stalled), std::pair(1e-7, Verdict::fine)}) {
    SinkWatch watch;
    Verdict worst = Verdict::fine;
    for (int i = 0; i < 5000 && worst == Verdict::fine; ++i)
      worst = watch.after(i * step, step, true, 10, 1e9);
    EXPECT_EQ(worst, verdict) << step;
  }
}

TEST(SinkWatch, StopsARunThatWouldExceedTheStepLimit) {
  // at most 1e9 steps: 10 s are 2e9 steps of 5e-9 s (reported after 200 000), but only 0.5e9 of 2e-8 s
  for (const auto& [step, verdict] : {std::pair(5e-9, Verdict::stalled), std::pair(2e-8, Verdict::fine)}) {
    SinkWatch watch;
    Verdict worst = Verdict::fine;
    int steps = 0;
    for (; steps < 1000000 && worst == Verdict::fine; ++steps)
      worst = watch.after(steps * step, step, true, 10, 1e9);
    EXPECT_EQ(worst, verdict) << step;
    if (verdict == Verdict::stalled) {
      EXPECT_NEAR(steps, 200000, 200);
    }
  }
}

/// A force along a slide by a law of position and speed.
template <class Law>
struct Along {
  Law law;
  template <class T>
  void apply(EffortPass<T>& pass) const {
    const auto at = pass.point(0, {0, 0, 0});
    const T force = law(T(at.p[0]), T(at.v[0]));
    pass.force(0, at.p, Eigen::Vector3<T>(force, T(0), T(0)));
    pass.power(T(force * at.v[0]));
  }
};

/// 1 kg on a slide without weight.
template <class Law>
Scene pushed(Law law, double speed) {
  Scene scene;
  scene.name = "pushed";
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), 0, speed)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"push", OwnEffort({{"mass"}}, {}, Along<Law>{law})}};
  return scene;
}

struct Growth {
  int power;
  template <class T>
  T operator()(const T&, const T& v) const {
    return power == 2 ? T(v * v) : T(v * v * v);
  }
};

struct DryFriction {
  template <class T>
  T operator()(const T&, const T& v) const {
    return either(
        v > 0, [] { return T(-1.5); }, [] { return T(2.5); });
  }
};

struct Wall {
  template <class T>
  T operator()(const T& x, const T&) const {
    return either(
        x < 0.5, [] { return T(1); }, [] { return T(1000); });
  }
};

TEST(Sinking, FiniteTimeBlowUpStopsEarly) {
  // dv/dt = v^2 from 1 m/s: v = 1 / (1 - t); and dv/dt = v^3: v = (1 - 2 t)^(-1/2)
  for (const std::string& method : integrator_names()) {
    if (!method_is_adaptive(method)) continue;
    for (const double tolerance : {1e-4, 1e-8, 1e-12})
      for (const int power : {2, 3}) {
        const System system = compiled(pushed(Growth{power}, 1));
        const double ends = power == 2 ? 1 : 0.5;
        long steps = 0;
        Observer observer;
        observer.progress = [&](double) { return ++steps < 200000; };
        SimulationSettings how = settings(method, 10, 0.01, tolerance);
        const Result<Trajectory> out = simulate(system, system.initial, how, observer);
        EXPECT_LT(steps, 100000) << method << ", " << tolerance;
        ASSERT_FALSE(out) << method << ", " << tolerance << ": " << out->certificate.reason;
        const std::string said = out.error().message();
        EXPECT_NE(said.find("'x'"), std::string::npos) << method << ", " << tolerance << ": " << said;
        const auto at = said.find("t = ");
        ASSERT_NE(at, std::string::npos) << said;
        EXPECT_NEAR(std::stod(said.substr(at + 4)), ends, 2e-3) << method << ": " << said;
      }
  }
}

TEST(Sinking, ChatteringForceStopsTheRun) {
  // dry friction without a law for rest: once the mass has stopped, after 1 / 1.5 s, its sign jumps with each
  // step
  const System system = compiled(pushed(DryFriction{}, 1));
  long steps = 0;
  Observer observer;
  observer.progress = [&](double) { return ++steps < 200000; };
  const Result<Trajectory> out =
      simulate(system, system.initial, settings("dopri5", 10, 0.01, 1e-12), observer);
  ASSERT_FALSE(out) << steps;
  for (const char* part :
       {"2000 step attempts advanced by only", "because of the velocity of 'x' of 'mass'", "t = 0.66666"})
    EXPECT_NE(out.error().what.find(part), std::string::npos) << out.error().what;
}

TEST(Sinking, ForceJumpIsPassed) {
  // 1 N, 1000 N beyond half a metre (extrapolated steps have no stage in their last part that would see the
  // jump)
  for (const char* method : {"rk4_adaptive", "dopri5", "dop853"}) {
    // from 1 m/s it is there after (sqrt 2 - 1) s, with sqrt 2 m/s
    const double t = 0.5, after = t - (std::sqrt(2.) - 1);
    const Trajectory out = run(pushed(Wall{}, 1), settings(method, t, 0.01, 1e-10));
    EXPECT_NEAR(last(out.q)[0], 0.5 + std::sqrt(2.) * after + 500 * after * after, 1e-4) << method;
  }
}

TEST(SinkWatch, NamesATopThatSpinsTooFast) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("top", "world", {ball("turn", identity_quaternion(), {1e9, 1e8, 1e8})},
                        {inertial(1, {0, 0, 0}, {0.1, 0.2, 0.25})})};
  for (const char* method : {"dop853", "gbs"}) {
    const System system = compiled(scene);
    const auto out = simulate(system, system.initial, settings(method, 10, 0.01, 1e-9));
    ASSERT_FALSE(out) << method;
    EXPECT_NE(out.error().message().find("'turn"), std::string::npos) << out.error().message();
    EXPECT_NE(out.error().message().find("would take more than 1e+09"), std::string::npos)
        << out.error().message();
  }
}

}  // namespace
}  // namespace borelli::test
