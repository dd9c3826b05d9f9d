// An ensemble equals its members run one by one.
#include "dynamics/run/ensemble.hpp"

#include <algorithm>
#include <numbers>

#include "each_width.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

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

class EnsembleInRegisters : public EachWidth {};
INSTANTIATE_TEST_SUITE_P(OfEachWidth, EnsembleInRegisters, ::testing::ValuesIn(all_widths()));

TEST_P(EnsembleInRegisters, FixedStepsEqualSingleRuns) {
  const System system = compiled(swing());
  const auto starts = members(system, 19);
  for (const char* method : {"rk4", "semi_implicit_euler", "verlet"}) {
    const SimulationSettings how = settings(method, 0.5, 0.005);
    const auto endings = need(simulate_ensemble(system, starts, how));
    ASSERT_EQ(endings.size(), 19u);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      EXPECT_FALSE(endings[i].alone) << method;
      EXPECT_EQ(endings[i].steps, 100);
      EXPECT_EQ(endings[i].state.t, 0.5);
      // rounding, 1e-15 a step, amplified by half a second of motion
      const Ending alone = single(system, starts[i].start, how);
      EXPECT_LT(distance(endings[i].state, alone.state), 1e-10) << method;
      EXPECT_EQ(endings[i].trusted, alone.trusted) << method << endings[i].reason;
      // 5 ms suffice at fourth order, not at first
      if (method != std::string("verlet")) {
        EXPECT_EQ(endings[i].trusted, method == std::string("rk4"));
      }
    }
  }
}

TEST_P(EnsembleInRegisters, AdaptiveStepsMeetTheMostDemandingLane) {
  const System system = compiled(swing());
  const auto starts = members(system, 8);
  const SimulationSettings fine = settings("dop853", 0.5, 0.01, 1e-12);
  for (const char* method : {"dopri5", "dop853", "rk4_adaptive", "gbs", "gauss16"}) {
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

TEST(Ensemble, IsIndependentOfThreads) {
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

TEST(Ensemble, ReportsProgressAndStopsOnRequest) {
  Scene scene = chain(2, false);
  scene.efforts = {{"stop", LimitSpring{{"h0"}, 500, 0.1, {{-0.5, 0.5}}}}};
  const System system = compiled(scene);
  std::vector<Member> starts(40, Member{system.initial, {}});
  starts[3].start.v[0] = starts[30].start.v[0] = 4;  // made alone
  const SimulationSettings how = settings("dopri5", 1, 0.01, 1e-9);
  for (const int threads : {1, 3}) {
    const auto whole = need(simulate_ensemble(system, starts, how, threads));
    std::vector<std::size_t> told;
    const auto watched = need(simulate_ensemble(system, starts, how, threads, [&](std::size_t made) {
      told.push_back(made);
      return true;
    }));
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_EQ(told.front(), 0u);
    EXPECT_EQ(told.back(), 40u);
    EXPECT_GT(told.size(), 5u * 20);  // progress at every step, not only per batch
    for (std::size_t i = 0; i < starts.size(); ++i) EXPECT_EQ(watched[i].state.q, whole[i].state.q);
    for (const std::size_t enough : {0, 8, 24}) {
      int after = 0;
      auto endings = need(simulate_ensemble(system, starts, how, threads, [&](std::size_t made) {
        if (made >= enough) ++after;
        return made < enough;
      }));
      EXPECT_EQ(after, 1);  // progress is not called again
      std::vector<Member> left;
      std::vector<std::size_t> places;
      for (std::size_t i = 0; i < starts.size(); ++i) {
        if (endings[i].reason != "stopped on request") {
          EXPECT_EQ(endings[i].state.q, whole[i].state.q);
          EXPECT_TRUE(endings[i].trusted);
          continue;
        }
        EXPECT_FALSE(endings[i].trusted || endings[i].alone);
        EXPECT_EQ(endings[i].state.q.size(), 0);
        left.push_back(starts[i]);
        places.push_back(i);
      }
      EXPECT_LE(left.size(), 40 - enough);
      EXPECT_GE(left.size() + 8 * (threads == 1 ? 0 : threads), 40 - enough);  // others may just have ended
      const auto rest = need(simulate_ensemble(system, left, how, threads));
      for (std::size_t k = 0; k < rest.size(); ++k)
        EXPECT_LT(distance(rest[k].state, whole[places[k]].state), 1e-6);  // by other steps
    }
  }
}

TEST(Ensemble, MembersUseTheirOwnInertials) {
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

// One bar on a hinge, weightless, and one on a slide: constant efforts, so q = v t + e t^2 / 2 m.
TEST(Ensemble, MembersUseTheirOwnEfforts) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("wheel", "world", {hinge("turn", Vector3d::UnitY())}, {link()}),
                  solid("sledge", "world", {slide("way", Vector3d::UnitX())}, {link()})};
  const System system = compiled(scene);
  const Inertial body = link();
  const double mass = body.mass,
               about_axis = (body.tensor + mass * (body.centre.squaredNorm() * Matrix3d::Identity() -
                                                   body.centre * body.centre.transpose()))(1, 1);
  std::vector<Member> starts(11, Member{system.initial, {}, {}});
  for (std::size_t i = 1; i < starts.size(); ++i)
    starts[i].efforts = Vector2d(0.3 * double(i), 1 - double(i));
  for (const char* method : {"rk4", "dopri5"}) {
    const auto endings = need(simulate_ensemble(system, starts, settings(method, 2, 0.1, 1e-9)));
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const Vector2d effort = i == 0 ? Vector2d(0, 0) : Vector2d(starts[i].efforts);
      const State& start = starts[i].start;
      EXPECT_NEAR(endings[i].state.q[0], start.q[0] + 2 * start.v[0] + 2 * effort[0] / about_axis, 1e-12);
      EXPECT_NEAR(endings[i].state.q[1], start.q[1] + 2 * start.v[1] + 2 * effort[1] / mass, 1e-12);
      EXPECT_TRUE(endings[i].trusted) << endings[i].reason;  // their work is in the balance
      EXPECT_LT(endings[i].energy_drift, 1e-13);
      EXPECT_FALSE(endings[i].alone);
    }
  }
}

/// A constant effort on a coordinate, or on a ball in its body axes.
struct Push {
  Vector3d effort;
  bool ball;

  template <class T>
  void apply(EffortPass<T>& pass) const {
    const Eigen::Vector3<T> e = effort.cast<T>();
    if (ball)
      pass.turning(0, e), pass.power(e.dot(pass.turn_rate(0)));
    else
      pass.coordinate(0, e[0]), pass.power(e[0] * pass.rate(0));
  }
};

/// The scene with these efforts as user-defined laws, which batches do not support.
Scene with_efforts(Scene scene, const System& system, const VectorXd& efforts) {
  for (const CoordinateInfo& info : system.coordinates) {
    Vector3d effort = Vector3d::Zero();
    effort.head(info.v_size) = efforts.segment(info.v_index, info.v_size);
    scene.efforts.push_back(
        {"push " + info.name, OwnEffort({}, {{info.name}}, Push{effort, info.q_size == 4})});
  }
  return scene;
}

TEST(Ensemble, MemberEffortsEqualThoseOfAScene) {
  const Scene scene = swing();
  const System system = compiled(scene);
  auto starts = members(system, 9);
  Random random(3);
  for (std::size_t i = 0; i < starts.size(); i += 2) starts[i].efforts = 0.5 * random.state(system).v;
  const SimulationSettings how = settings("rk4", 0.5, 0.005);
  const auto endings = need(simulate_ensemble(system, starts, how));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const System alike = i % 2 == 0 ? compiled(with_efforts(scene, system, starts[i].efforts)) : system;
    EXPECT_LT(distance(endings[i].state, single(alike, starts[i].start, how).state), 1e-10) << i;
    EXPECT_TRUE(endings[i].trusted) << endings[i].reason;
    EXPECT_FALSE(endings[i].alone);
  }
}

TEST(Ensemble, MemberRunAloneKeepsItsEfforts) {
  Scene scene = chain(2, false);
  scene.efforts = {{"stop", LimitSpring{{"h0"}, 500, 0.1, {{-0.5, 0.5}}}}};
  const System system = compiled(scene);
  std::vector<Member> starts(10, Member{system.initial, {}, Vector2d(0.01, 0)});
  for (std::size_t i = 0; i < starts.size(); i += 3) starts[i].efforts[0] = 20 + double(i);
  const SimulationSettings how = settings("dopri5", 1, 0.01, 1e-9);
  const auto endings = need(simulate_ensemble(system, starts, how));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_EQ(endings[i].alone, i % 3 == 0) << i;
    EXPECT_TRUE(endings[i].trusted) << endings[i].reason;
    const System alike = compiled(with_efforts(scene, system, starts[i].efforts));
    EXPECT_LT(distance(endings[i].state, single(alike, starts[i].start, how).state), 1e-6) << i;
  }
}

TEST(Ensemble, MemberThatHitsAStopRunsAlone) {
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

// A member that diverges leaves its batch without affecting the others.
TEST(Ensemble, DivergingMemberDoesNotAffectOthers) {
  const System system = compiled(chain(2, false, 1));
  for (const char* method : {"rk4", "dop853", "gauss16", "verlet"})
    for (const double wild : {3e12, 1e200}) {
      auto starts = members(system, 8);
      starts[5].start.v[0] = wild;
      const SimulationSettings how = settings(method, 0.5, 0.005, 1e-9);
      const auto endings = need(simulate_ensemble(system, starts, how, 1));
      for (std::size_t i = 0; i < starts.size(); ++i) {
        EXPECT_EQ(endings[i].alone, i == 5) << method << wild;
        EXPECT_EQ(endings[i].trusted, i != 5) << endings[i].reason;
        if (i == 5) continue;
        EXPECT_LT(distance(endings[i].state, single(system, starts[i].start, how).state), 1e-6);
      }
      EXPECT_TRUE(endings[5].reason.find("the run ends at") != std::string::npos ||
                  endings[5].reason.find("cannot be met") != std::string::npos)
          << endings[5].reason;
    }
}

// A dashpot stops one light sledge of eight within a step, so verlet's half step does not converge there.
TEST(Ensemble, UnconvergedStepAffectsOnlyItsLane) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("sledge", "world", {slide("way", Vector3d::UnitX())}, {link()})};
  scene.efforts = {{"dashpot", CoordinateSpring{{"way"}, 0, 1}}};
  const System system = compiled(scene);
  std::vector<Member> starts(8, Member{system.initial, system.parameters.inertials});
  for (Member& one : starts) one.start.v[0] = 1;
  starts[3].inertials.back().mass *= 1e-3;
  starts[3].inertials.back().tensor *= 1e-3;
  const auto endings = need(simulate_ensemble(system, starts, settings("verlet", 0.5, 0.01)));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    EXPECT_EQ(endings[i].alone, i == 3) << i;
    EXPECT_EQ(endings[i].trusted, i != 3) << endings[i].reason;
    if (i != 3) {  // v = exp(-c t / m); the rule's error goes as (c h / m)^2
      EXPECT_NEAR(endings[i].state.v[0], std::exp(-0.5 / starts[i].inertials.back().mass), 1e-5);
    }
  }
  EXPECT_NE(endings[3].reason.find("the half step of the velocity did not converge"), std::string::npos)
      << endings[3].reason;
}

// All coordinates are driven: the drives' work alone controls the steps, as in simulate().
TEST(Ensemble, ControlsTheWorkOfDrivesAsSingleRunsDo) {
  Scene scene = chain(2, false, 0.3);
  for (Solid& one : scene.solids) one.switches.back() = driven(one.switches.back(), Sine{0.5, 20, 0, 0.1});
  const System system = compiled(scene);
  for (const char* method : {"gbs", "rk4_adaptive", "dop853", "gauss16"}) {
    const SimulationSettings how = settings(method, 0.5, 0.05, 1e-9);
    const auto endings = need(simulate_ensemble(system, members(system, 3), how));
    const Trajectory alone = need(simulate(system, system.initial, how));
    EXPECT_TRUE(alone.certificate.trusted) << alone.certificate.reason;
    for (const Ending& ending : endings) EXPECT_TRUE(ending.trusted) << method << ending.reason;
  }
}

TEST(Ensemble, DistrustsMotionsWhoseEnergyDrifts) {
  const System system = compiled(chain(2, false, 1));
  const auto endings = need(simulate_ensemble(system, members(system, 8), settings("euler", 1, 0.02)));
  for (const Ending& ending : endings) {
    EXPECT_FALSE(ending.trusted);
    EXPECT_NE(ending.reason.find("energy balance of 'l0'"), std::string::npos) << ending.reason;
  }
}

TEST(Ensemble, DistrustsFixedStepsLongerThanTheScenesWaves) {
  Scene scene = chain(1, false);
  Torque push{{"l0"}, {0, 1, 0}};
  push.factor = Sine{1, 50, 0, 0};
  scene.efforts = {{"push", push}};
  const System system = compiled(scene);
  const auto endings = need(simulate_ensemble(system, members(system, 1), settings("rk4", 0.5, 0.05)));
  EXPECT_FALSE(endings[0].trusted);
  EXPECT_NE(endings[0].reason.find("effort 'push'"), std::string::npos) << endings[0].reason;
}

// Wheels fast enough to pass the half turn of their spring run alone.
TEST(Ensemble, MembersWhoseTorsionSpringsTurnRoundRunAlone) {
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

// One of eight starts where two axes of its joint coincide, so its acceleration is undefined.
TEST(Ensemble, MemberThatCannotStartDoesNotAffectOthers) {
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

TEST(Ensemble, RefusesUnsupportedRequests) {
  const System system = compiled(chain(2, false));
  auto starts = members(system, 3);
  EXPECT_EQ(simulate_ensemble(system, starts, settings("cvode", 1, 0.01)).error().where, "method 'cvode'");
  starts[1].start.t = 1;
  EXPECT_EQ(simulate_ensemble(system, starts, settings("rk4", 2, 0.01)).error().where, "member 1");
  starts[1].start.t = 0;
  starts[2].inertials.resize(1);
  EXPECT_EQ(simulate_ensemble(system, starts, settings("rk4", 2, 0.01)).error().where, "member 2");
  starts[2].inertials.clear();
  for (const VectorXd& wrong : {VectorXd(VectorXd::Zero(3)), VectorXd(Vector2d(0, std::nan("")))}) {
    starts[0].efforts = wrong;
    EXPECT_EQ(simulate_ensemble(system, starts, settings("rk4", 2, 0.01)).error().where, "member 0");
  }
  // impossible bodies: the error names the first member with one, whichever thread finds one first
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
