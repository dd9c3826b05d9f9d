// Events located in whole runs, against closed forms: a bouncing point, ranges left and entered, excursions
// within one step, several at once. Also the root finder.
#include "dynamics/run/event_watch.hpp"

#include <cmath>

#include "dynamics/numbers/root.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

TEST(RootFinding, IsFoundToRoundingInFewEvaluations) {
  for (const auto& [f, root] :
       {std::pair<double (*)(double), double>([](double x) { return std::cos(x) - x; }, 0.7390851332151607),
        {[](double x) { return x * x * x - 1e-3; }, 0.1},
        {[](double x) { return std::exp(20 * x) - std::exp(10.0); }, 0.5}}) {
    int count = 0;
    Root out;
    ASSERT_TRUE(find_root(
        [&](double x, double& y) {
          y = f(x);
          return ++count > 0;
        },
        0, f(0), 1, f(1), 1e-15, out));
    EXPECT_NEAR(out.before, root, 2e-15);
    EXPECT_NEAR(out.after, root, 2e-15);
    EXPECT_GE(f(0) * f(out.before), 0);
    EXPECT_LE(f(0) * f(out.after), 0);
    EXPECT_LT(count, 20);  // bisection takes 50
  }
}

TEST(RootFinding, SaysWhenTheFunctionHasNoValue) {
  Root out;
  EXPECT_FALSE(find_root([](double, double&) { return false; }, 0, 1, 1, -1, 1e-12, out));
}

/// Points that fall on a floor at z = 0 and rebound with a share of their speed.
class Floor : public EventSource {
 public:
  Floor(int points, double restitution) : points_(points), restitution_(restitution) {}
  int count() const override { return points_; }
  Crossing crossing(int) const override { return Crossing::falling; }
  void evaluate(const State& state, const Kinematics&, std::span<EventValue> values) override {
    for (int i = 0; i < points_; ++i) values[i] = {state.q[i], state.v[i]};
  }
  Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                            std::vector<LoggedEvent>& log) override {
    EXPECT_EQ(workspace.kinematics.t, state.t);  // the kinematics belong to this state
    for (int i : which) {
      state.v[i] *= -restitution_;
      log.push_back({state.t, "bounce", fmt::format("point {}", i)});
    }
    return AfterEvent::restart;
  }

 private:
  int points_;
  double restitution_;
};

Scene falling(const std::vector<double>& heights) {
  Scene scene;
  for (std::size_t i = 0; i < heights.size(); ++i)
    scene.solids.push_back(solid(fmt::format("p{}", i), "world",
                                 {slide(fmt::format("z{}", i), Vector3d::UnitZ(), heights[i])},
                                 {inertial(1 + double(i), {0, 0, 0}, {0, 0, 0})}));
  return scene;
}

Trajectory run_with(const Scene& scene, const SimulationSettings& how, EventSource& source) {
  const System system = compiled(scene);
  Observer observer;
  observer.events = {&source};
  return need(simulate(system, system.initial, how, observer));
}

TEST(Events, BouncingPointHitsTheFloorAtTheClosedFormTimes) {
  const double h = 1.3, e = 0.8, g = 9.81, first = std::sqrt(2 * h / g);
  for (const std::string& method : integrator_names()) {
    if (method.ends_with("euler") || method == "cvode") continue;  // begin at order 1: no parabola
    Floor floor(1, e);
    const Trajectory path = run_with(falling({h}), settings(method, 2.7, 0.01, 1e-9), floor);
    const auto& events = path.certificate.events;
    double t = first, flight = 2 * first * e;
    ASSERT_EQ(events.size(), 4u) << method;
    for (const LoggedEvent& event : events) {
      EXPECT_NEAR(event.time, t, 1e-12) << method;
      EXPECT_EQ(event.kind, "bounce");
      t += flight;
      flight *= e;
    }
    // time into the flight after the fourth impact
    const double since = 2.7 - (t - flight / e), speed = g * flight / e / 2;
    EXPECT_NEAR(last(path.q)[0], speed * since - g * since * since / 2, 1e-11) << method;
    // each impact takes 1 - e^2 of the energy, as the balance records
    EXPECT_NEAR(path.certificate.work_events, -g * h * (1 - std::pow(e, 8)), 1e-11) << method;
    EXPECT_TRUE(path.certificate.trusted) << method << ": " << path.certificate.reason;
    EXPECT_LT(path.certificate.energy_drift, 1e-11) << method;
  }
}

TEST(Events, DoNotShiftOutputRows) {
  SimulationSettings how = settings("dopri5", 1, 0.01, 1e-9);
  how.output_interval = 0.01;
  Floor floor(1, 1);
  const Trajectory path = run_with(falling({0.5}), how, floor);
  ASSERT_EQ(path.times.size(), 101u);
  const double g = 9.81, down = std::sqrt(2 * 0.5 / g);
  for (std::size_t i = 0; i < path.times.size(); ++i) {
    const double since = std::remainder(path.times[i], 2 * down);  // time from the top
    EXPECT_NEAR(path.q(Eigen::Index(i), 0), 0.5 - g * since * since / 2, 1e-11);
  }
}

TEST(Events, SimultaneousOnesComeTogetherOthersInOrder) {
  Floor floor(3, 0.5);
  const Trajectory path = run_with(falling({1, 0.5, 1}), settings("dop853", 0.6, 0.01, 1e-9), floor);
  std::vector<std::string> names;
  for (const LoggedEvent& event : path.certificate.events) names.push_back(event.name);
  EXPECT_EQ(names, (std::vector<std::string>{"point 1", "point 0", "point 2"}));
  EXPECT_DOUBLE_EQ(path.certificate.events[1].time, path.certificate.events[2].time);
}

/// An oscillator passes a limit slightly and comes back within one long step.
TEST(Events, FindsAnExcursionWithinOneStep) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {
      solid("mass", "world", {slide("x", Vector3d::UnitX(), 0, 1)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, 1, 0, 0}}};  // x = sin t
  scene.solids[0].switches[0].ranges = {Range{-2, 0.99999}};
  for (const char* method : {"rk4", "rk4_adaptive", "dopri5", "dop853", "gbs", "gauss16"}) {
    const Trajectory path = run(scene, settings(method, 3, method == std::string("rk4") ? 0.02 : 0.5, 1e-10));
    const auto& events = path.certificate.events;
    ASSERT_EQ(events.size(), 2u) << method;
    // at x = 1 - 1e-5 its rate is 4.5e-3, so an error of x counts 200 times in time
    EXPECT_NEAR(events[0].time, std::asin(0.99999), 1e-6) << method;
    EXPECT_NEAR(events[1].time, M_PI - std::asin(0.99999), 1e-6) << method;
    EXPECT_EQ(events[0].kind, "range_left");
    EXPECT_EQ(events[0].name, "coordinate 'x' above 0.99999");
    EXPECT_EQ(events[1].kind, "range_entered");
    ASSERT_EQ(path.certificate.notes.size(), 1u);
    EXPECT_NE(path.certificate.notes[0].find("left its range of -2 to 0.99999 at t = 1.566"),
              std::string::npos);
  }
}

TEST(Events, NotesDoNotChangeTheMotion) {
  Scene scene = roundabout();
  const SimulationSettings how = settings("dopri5", 2, 0.01, 1e-8);
  const Trajectory without = run(scene, how);
  scene.solids[1].switches[1].ranges = {Range{-0.5, 0.5}};
  const Trajectory with = run(scene, how);
  EXPECT_GT(with.certificate.events.size(), 2u);
  EXPECT_EQ(with.step_sizes, without.step_sizes);
  EXPECT_EQ(last(with.q), last(without.q));
}

TEST(Events, OnConstraintsAreLocatedThere) {
  // IFToMM's A01: the point passes below its pivot, x = 0, after a quarter of its period, again each half
  // period
  Scene scene;
  scene.solids = {solid("point", "world",
                        {slide("x", Vector3d::UnitX(), -1), slide("z", Vector3d::UnitZ(), 0)},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.constraints = {{"rod", Distance{{"point", {0, 0, 0}}, {"world", {0, 0, 0}}, constant(1)}}};
  scene.solids[0].switches[0].ranges = {Range{-2, 0}};
  const double period = 2.36784194757623745;
  for (const char* method : {"dopri5", "dop853", "gbs", "gauss16", "rk4_adaptive"}) {
    const auto events = run(scene, settings(method, 5, 0.01, 1e-11)).certificate.events;
    ASSERT_EQ(events.size(), 4u) << method;
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(events[i].time, (0.25 + 0.5 * i) * period, 1e-9) << method;
  }
}

TEST(Events, EndlessOnesAtOneTimeAreRefused) {
  struct Stuck : Floor {
    Stuck() : Floor(1, 0) {}
    void evaluate(const State& state, const Kinematics&, std::span<EventValue> values) override {
      values[0] = {state.q[0] > 0 ? 1.0 : -1.0, 1};  // its rate says that it leaves, but it stays
    }
  } stuck;
  const System system = compiled(falling({1}));
  Observer observer;
  observer.events = {&stuck};
  const auto out = simulate(system, system.initial, settings("rk4", 1, 0.01), observer);
  ASSERT_FALSE(out);
  EXPECT_NE(out.error().what.find("events follow each other at the same time, the last of them bounce at "
                                  "'point 0'; the run ends at t = 0.45"),
            std::string::npos)
      << out.error().what;
}

// Functions with a hundred thousand waves per step that never reach zero. One is checked at the finest
// resolution; sixteen exceed the number of checks and are refused.
TEST(Events, TooManyChecksInAStepAreRefused) {
  struct Waves : Floor {
    explicit Waves(int count) : Floor(count, 1) {}
    void evaluate(const State& state, const Kinematics&, std::span<EventValue> values) override {
      constexpr double fast = 6e6;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const double phase = fast * state.t + double(i);
        values[i] = {1.1 + std::cos(phase), -fast * std::sin(phase)};
        values[i].speed = fast;
      }
    }
  };
  const System system = compiled(falling({100}));
  for (const int count : {1, 16}) {
    Waves waves(count);
    Observer observer;
    observer.events = {&waves};
    const auto out = simulate(system, system.initial, settings("rk4", 0.2, 0.1), observer);
    EXPECT_EQ(out.has_value(), count == 1);
    if (!out) {
      EXPECT_NE(out.error().what.find("more often than 32768 checks can resolve"), std::string::npos)
          << out.error().what;
    }
  }
}

}  // namespace
}  // namespace borelli::test
