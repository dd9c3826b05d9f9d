// Many motions at once against each by itself.
#include "dynamics/ensemble.hpp"

#include <numbers>

#include "scenes.hpp"

namespace borelli::test {
namespace {

Scene swing() {
  Scene scene = random_tree(2, {.balls = true});
  scene.efforts = {
      {"pull", PointSpring{{scene.solids[1].name, {0, 0, 0.1}}, {"world", {1, 0, 0}}, 20, 0.5, 0.3}}};
  return scene;
}

std::vector<Member> members(const System& system, int count) {
  std::vector<Member> out;
  for (int i = 0; i < count; ++i) out.push_back({Random(100 + i).state(system), {}});
  for (Member& one : out) one.start.t = 0;
  return out;
}

double distance(const State& a, const State& b) {
  return (a.q - b.q).cwiseAbs().maxCoeff() + (a.v - b.v).cwiseAbs().maxCoeff();
}

Ending single(const System& system, const State& start, const SimulationSettings& how) {
  const Trajectory motion = need(simulate(system, start, how));
  return {.state = {motion.times.back(), last(motion.q), last(motion.v)},
          .trusted = motion.certificate.trusted};
}

TEST(Ensemble, FixedStepsAreThoseOfSingleMotions) {
  const System system = compiled(swing());
  const SimulationSettings how = settings("rk4", 0.5, 0.005);
  const auto starts = members(system, 19);
  const auto endings = need(simulate_ensemble(system, starts, how));
  ASSERT_EQ(endings.size(), 19u);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_FALSE(endings[i].alone);
    EXPECT_EQ(endings[i].steps, 100);
    EXPECT_EQ(endings[i].state.t, 0.5);
    // rounding, 1e-15 a step, times what half a second of swinging makes of it
    EXPECT_LT(distance(endings[i].state, single(system, starts[i].start, how).state), 1e-10);
    EXPECT_TRUE(endings[i].trusted) << endings[i].reason;
  }
}

TEST(Ensemble, AdaptiveStepsServeTheLaneThatAsksForMost) {
  const System system = compiled(swing());
  const auto starts = members(system, 8);
  const SimulationSettings fine = settings("dop853", 0.5, 0.01, 1e-12);
  for (const char* method : {"dopri5", "dop853", "rk4_adaptive", "gbs"}) {
    const SimulationSettings how = settings(method, 0.5, 0.01, 1e-8);
    const auto endings = need(simulate_ensemble(system, starts, how, 1));
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const State exact = single(system, starts[i].start, fine).state;
      // errors of some steps, each below the tolerance on scales of about 1
      EXPECT_LT(distance(endings[i].state, exact), 1e-5) << method;
      EXPECT_TRUE(endings[i].trusted) << endings[i].reason;
      EXPECT_FALSE(endings[i].alone) << method;
    }
  }
}

TEST(Ensemble, DoesNotHangOnThreads) {
  const System system = compiled(swing());
  const auto starts = members(system, 40);
  const SimulationSettings how = settings("dopri5", 0.3, 0.01, 1e-6);
  const auto one = need(simulate_ensemble(system, starts, how, 1)),
             three = need(simulate_ensemble(system, starts, how, 3));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_EQ(one[i].state.q, three[i].state.q);
    EXPECT_EQ(one[i].state.v, three[i].state.v);
  }
}

TEST(Ensemble, MembersMayHaveTheirOwnInertials) {
  const System system = compiled(chain(3, true, 0.5));
  std::vector<Member> starts(5, Member{system.initial, system.parameters.inertials});
  for (std::size_t i = 0; i < starts.size(); ++i) starts[i].inertials[2].mass *= 1.0 + double(i);
  const SimulationSettings how = settings("rk4", 1, 0.01);
  const auto endings = need(simulate_ensemble(system, starts, how));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    System varied = system;
    varied.parameters.inertials = starts[i].inertials;
    EXPECT_LT(distance(endings[i].state, single(varied, system.initial, how).state), 1e-11);
  }
  EXPECT_GT(distance(endings[0].state, endings[4].state), 1e-2);
}

TEST(Ensemble, AMotionThatMeetsABoundIsMadeAlone) {
  Scene scene = chain(2, false);
  scene.efforts = {{"stop", LimitSpring{{"h0"}, 500, 0.1, {{-0.5, 0.5}}}}};
  const System system = compiled(scene);
  std::vector<Member> starts(10, Member{system.initial, {}});
  for (std::size_t i = 0; i < starts.size(); ++i) starts[i].start.v[0] = i % 3 == 0 ? 4 : 0.2;
  const SimulationSettings how = settings("dopri5", 1, 0.01, 1e-9);
  const auto endings = need(simulate_ensemble(system, starts, how));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_EQ(endings[i].alone, i % 3 == 0) << i;
    EXPECT_TRUE(endings[i].trusted) << endings[i].reason;
    EXPECT_LT(distance(endings[i].state, single(system, starts[i].start, how).state), 1e-6);
  }
}

TEST(Ensemble, TrustsNoMotionWhoseEnergyDrifts) {
  const System system = compiled(chain(2, false, 1));
  const auto endings = need(simulate_ensemble(system, members(system, 8), settings("euler", 1, 0.02)));
  for (const Ending& ending : endings) {
    EXPECT_FALSE(ending.trusted);
    EXPECT_NE(ending.reason.find("energy balance of 'l0'"), std::string::npos) << ending.reason;
  }
}

TEST(Ensemble, TrustsNoFixedStepsThatPassOverTheScenesOwnWaves) {
  Scene scene = chain(1, false);
  Torque push{{"l0"}, {0, 1, 0}};
  push.factor = Sine{1, 50, 0, 0};
  scene.efforts = {{"push", push}};
  const System system = compiled(scene);
  const auto endings = need(simulate_ensemble(system, members(system, 1), settings("rk4", 0.5, 0.05)));
  EXPECT_FALSE(endings[0].trusted);
  EXPECT_NE(endings[0].reason.find("effort 'push'"), std::string::npos) << endings[0].reason;
}

// Of eight wheels those that are fast enough to pass the half turn of their spring are made alone.
TEST(Ensemble, TorsionSpringsThatTurnRoundAreLeftToRunsAlone) {
  const System system = compiled(wheel(2, 0));  // 1/2 0.8 w^2 = 1/2 2 pi^2
  const double enough = std::numbers::pi * std::sqrt(2 / 0.8);
  std::vector<Member> starts(8, Member{system.initial, {}});
  for (std::size_t i = 0; i < starts.size(); ++i) starts[i].start.v[0] = enough * (0.65 + 0.1 * double(i));
  SimulationSettings how = settings("dop853", 3, 0.1);
  how.tolerance = 1e-9;
  const auto endings = need(simulate_ensemble(system, starts, how));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_EQ(endings[i].alone, i >= 4) << i;
    EXPECT_TRUE(endings[i].trusted) << i;
    EXPECT_LT(distance(endings[i].state, single(system, starts[i].start, how).state), 1e-7) << i;
  }
}

// One of eight starts where two axes of its joint lie along each other: no acceleration can be told there.
TEST(Ensemble, AMotionThatCannotBeginHinderesNoOther) {
  const System system = compiled(aligning_turns());
  std::vector<Member> starts(8, Member{system.initial, {}});
  for (std::size_t i = 0; i < starts.size(); ++i) starts[i].start.v = Vector3d(0.1, 0.1, double(i));
  starts[2].start.q[1] = 0;
  const SimulationSettings how = settings("rk4", 0.5, 0.01);
  const auto endings = need(simulate_ensemble(system, starts, how));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_EQ(endings[i].alone, i == 2);
    EXPECT_EQ(endings[i].trusted, i != 2);
    if (i == 2) continue;
    EXPECT_LT(distance(endings[i].state, single(system, starts[i].start, how).state), 1e-11);
  }
  EXPECT_NE(endings[2].reason.find("mass matrix is singular"), std::string::npos) << endings[2].reason;
  EXPECT_EQ(endings[2].state.q.size(), 0);
}

TEST(Ensemble, RefusesWhatItCannotDo) {
  const System system = compiled(chain(2, false));
  auto starts = members(system, 3);
  EXPECT_EQ(simulate_ensemble(system, starts, settings("cvode", 1, 0.01)).error().where, "method 'cvode'");
  starts[1].start.t = 1;
  EXPECT_EQ(simulate_ensemble(system, starts, settings("rk4", 2, 0.01)).error().where, "member 1");
  starts[1].start.t = 0;
  starts[2].inertials.resize(1);
  EXPECT_EQ(simulate_ensemble(system, starts, settings("rk4", 2, 0.01)).error().where, "member 2");
  // bodies that cannot exist: the first member that has one is told, whoever comes upon it first
  starts.assign(40, Member{system.initial, system.parameters.inertials});
  const auto refused = [&](std::size_t member, auto&& change) {
    auto wrong = starts;
    change(wrong[member].inertials[1]);
    change(wrong[39].inertials[2]);
    const auto endings = simulate_ensemble(system, wrong, settings("rk4", 2, 0.01), 2);
    ASSERT_FALSE(endings);
    EXPECT_EQ(endings.error().where, "member " + std::to_string(member) + ", body 1");
    EXPECT_EQ(endings.error().kind, Error::Kind::use);
  };
  refused(17, [](Inertial& body) { body.tensor = -body.tensor.eval(); });
  refused(3, [](Inertial& body) { body.mass = -1; });
  refused(38, [](Inertial& body) { body.mass = std::numeric_limits<double>::infinity(); });
  refused(0, [](Inertial& body) { body.centre[2] = std::nan(""); });
  EXPECT_EQ(need(simulate_ensemble(system, starts, settings("rk4", 2, 0.01))).size(), 40u);
  EXPECT_TRUE(need(simulate_ensemble(system, {}, settings("rk4", 2, 0.01))).empty());
}

}  // namespace
}  // namespace borelli::test
