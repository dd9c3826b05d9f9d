// A run that is stopped and resumed equals the uninterrupted run bit for bit.
#include <cstring>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/numbers/keeper.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// The trajectory with its certificate, as bytes.
std::string bytes_of(Trajectory t) {
  Keeper k;
  Certificate& c = t.certificate;
  k(t.times, t.q, t.v, t.a, t.poses, t.gravity_centre, t.linear_momentum, t.angular_momentum, t.multipliers,
    t.contact_modes, t.contact_forces, t.driven_positions, t.driven_efforts, t.kinetic, t.potential, t.work,
    t.step_times, t.step_sizes, c, c.energy_drift, c.energy_drift_time, c.energy_turnover, c.energy_threshold,
    c.work_efforts, c.work_drives, c.work_constraints, c.work_baumgarte, c.work_projection,
    c.work_projection_size, c.work_events, c.work_events_size, c.contacts, c.contact_error,
    c.assembly_position, c.assembly_velocity, c.assembly_position_coordinate, c.assembly_velocity_coordinate,
    c.constraint_rows, c.nearness, c.nearness_time, c.singular_passages, c.singular_turn, c.evaluations,
    c.accuracy, c.estimated_error);
  return k.bytes();
}

/// Stops a run four times, after 1 step and a fifth, a third and a quarter of all steps, and resumes it each
/// time. Compares it with the uninterrupted run and returns that.
Trajectory compare(const Scene& scene, const SimulationSettings& how) {
  const System system = compiled(scene);
  const std::string name = scene.name + " by " + how.method;
  const Trajectory whole = need(simulate(system, system.initial, how));
  Observer observer;
  std::string kept;
  observer.keep = [&](const std::string& checkpoint) { kept = checkpoint; };
  const long count = whole.certificate.steps_accepted;
  for (const long stop : {1L, count / 5, count / 3, count / 4}) {
    long steps = 0;
    observer.progress = [&](double) { return ++steps < stop; };
    const Trajectory part = need(simulate(system, system.initial, how, observer));
    EXPECT_EQ(part.certificate.reason.substr(0, 10), "stopped on") << name;
    observer.checkpoint = kept;
  }
  observer.progress = nullptr;
  observer.keep = nullptr;
  const Trajectory taken_up = need(simulate(system, system.initial, how, observer));
  EXPECT_EQ(taken_up.times.size(), whole.times.size()) << name;
  EXPECT_TRUE(bytes_of(taken_up) == bytes_of(whole)) << name;
  return whole;
}

SimulationSettings rows_every(SimulationSettings s, double interval) {
  s.output_interval = interval;
  return s;
}

TEST(Checkpoint, EveryMethodResumesBitForBit) {
  Scene scene = chain(3, true, 0.5);
  scene.solids.push_back(solid("ball", "l2",
                               {fixed({0, 0, -1}), ball("turn", identity_quaternion(), {1, 2, 3})},
                               {inertial(1, {0.1, 0, -0.2}, {0.03, 0.04, 0.05})}));
  for (const char* method :
       {"euler", "rk2", "rk4", "rk4_adaptive", "dopri5", "dop853", "gbs", "gauss16", "gbs4", "gbs8",
        "semi_implicit_euler", "verlet", "implicit_midpoint", "gauss4", "gauss6"})
    for (const double interval : {0.0, 0.03, 0.25})
      compare(scene, rows_every(settings(method, 1, 1e-2, 1e-8), interval));
}

// A spring so stiff that the collocation switches to Newton's method and keeps its factors.
TEST(Checkpoint, StoresTheFactorsOfImplicitSteps) {
  Scene scene = chain(2, false, 0.3);
  scene.efforts = {{"stiff", CoordinateSpring{{"h1"}, 1e6, 10, 0.3}}};
  compare(scene, rows_every(settings("gauss4", 1, 1e-2), 0.1));
}

TEST(Checkpoint, StoresDrivesRangesAndPeriods) {
  Scene scene = chain(3, false, 0.1);
  scene.name = "driven";
  scene.solids[0].switches.back() = driven(scene.solids[0].switches.back(), Sine{0.5, 6, 0, 0});
  scene.solids[1].switches.back().ranges = {{-0.3, 0.3}};
  scene.efforts = {{"push", Force{{"l2", {0, 0, -1}}, {1, 0, 0}, Axes::world, Sine{2, 5, 0, 0}, {}}}};
  const Trajectory motion = compare(scene, rows_every(settings("dopri5", 3, 1e-2, 1e-8), 0.1));
  EXPECT_FALSE(motion.certificate.events.empty());
}

// A weight leaves its stop and falls on it again: the start state alone does not say whether the stop pushes.
TEST(Checkpoint, StoresActiveStops) {
  Scene scene;
  scene.name = "stop";
  scene.solids = {solid("weight", "world", {slide("z", Vector3d::UnitZ(), 0.05)}, {link()})};
  scene.efforts = {{"stop", LimitSpring{{"z"}, 100, 0.1, {{0, 100}}}}};
  for (const char* method : {"rk4", "gbs", "dop853"}) {
    const Trajectory motion = compare(scene, rows_every(settings(method, 3, 1e-2, 1e-8), 0.1));
    EXPECT_TRUE(motion.certificate.trusted) << motion.certificate.reason;
    EXPECT_FALSE(motion.certificate.events.empty());
  }
}

TEST(Checkpoint, StoresContactsAndTheirLosses) {
  for (const char* name : {"bouncing_ball.toml", "block_on_slope.toml", "cradle.toml"}) {
    Scene scene = sample(name);
    scene.simulation.end_time = std::min(scene.simulation.end_time, 2.5);
    const Trajectory motion = compare(scene, scene.simulation);
    EXPECT_FALSE(motion.certificate.events.empty()) << name;
    compare(scene, rows_every(scene.simulation, 0.013));
  }
}

// A small ball at 60 m/s hits another one. Steps of 10 ms would pass through it, so they are made in parts.
TEST(Checkpoint, StoresAPartlyFinishedStep) {
  Scene scene;
  scene.gravity.setZero();
  for (const char* name : {"fast", "still"})
    scene.solids.push_back(
        solid(name, "world", {slide(name, Vector3d::UnitX(), *name == 'f' ? 0 : 0.7, *name == 'f' ? 60 : 0)},
              {inertial(1, {0, 0, 0}, {1, 1, 1})}));
  SphereOverSphere meet;
  meet.a = {"fast", {0, 0, 0}};
  meet.b = {"still", {0, 0, 0}};
  meet.radii = {0.005, 0.005};
  scene.constraints = {{"meet", meet}};
  const SimulationSettings how = settings("moreau", 0.1, 1e-2);
  const System system = compiled(scene);
  std::vector<double> ends;
  Observer observer;
  observer.progress = [&](double t) {
    ends.push_back(t);
    return true;
  };
  const Trajectory whole = need(simulate(system, system.initial, how, observer));
  std::size_t inside = 0;  // the steps that end within one of 10 ms
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (std::abs(ends[i] - std::round(ends[i] / 1e-2) * 1e-2) < 1e-9) continue;
    ++inside;
    Observer other;
    std::string kept;
    std::size_t steps = 0;
    other.keep = [&](const std::string& checkpoint) { kept = checkpoint; };
    other.progress = [&](double) { return ++steps < i + 1; };
    need(simulate(system, system.initial, how, other));
    other = {};
    other.checkpoint = kept;
    EXPECT_TRUE(bytes_of(need(simulate(system, system.initial, how, other))) == bytes_of(whole)) << ends[i];
  }
  EXPECT_GT(inside, 1u);
}

TEST(Checkpoint, StoresTheStateOfTheSingularWatch) {
  const Scene scene = sample("four_bar_2.toml");
  EXPECT_LT(compare(scene, scene.simulation).certificate.nearness, 0.3);
  EXPECT_EQ(compare(crossing(1, 0), rows_every(settings("rk4", 1, 0.0625), 0)).certificate.singular_passages,
            1);
}

TEST(Checkpoint, IsRefusedIfDamagedOrOfAnotherRun) {
  const System system = compiled(chain(2, false, 0.5));
  SimulationSettings how = settings("dopri5", 1, 1e-2);
  Observer observer;
  std::string kept;
  observer.keep = [&](const std::string& checkpoint) { kept = checkpoint; };
  int steps = 0;
  observer.progress = [&](double) { return ++steps < 5; };
  need(simulate(system, system.initial, how, observer));
  observer = {};
  for (std::size_t length = 1; length < kept.size(); length += 1 + kept.size() / 50) {
    observer.checkpoint = kept.substr(0, length);
    EXPECT_FALSE(simulate(system, system.initial, how, observer)) << length;
  }
  for (std::size_t at = 0; at < kept.size(); at += 1 + kept.size() / 200) {  // one byte is changed
    observer.checkpoint = kept;
    observer.checkpoint[at] = char(observer.checkpoint[at] ^ 4);
    const auto out = simulate(system, system.initial, how, observer);
    ASSERT_FALSE(out) << at;
    EXPECT_EQ(out.error().what, "is damaged; remove it to start again") << at;
  }
  observer.checkpoint = kept + "x";
  EXPECT_FALSE(simulate(system, system.initial, how, observer));
  // complete, but with extra data at the end
  std::string other = kept.substr(0, kept.size() - sizeof(std::uint64_t)) + "more";
  const std::uint64_t digest = checksum_of(other);
  other.append(reinterpret_cast<const char*>(&digest), sizeof digest);
  observer.checkpoint = other;
  EXPECT_EQ(simulate(system, system.initial, how, observer).error().what,
            "does not fit this version of the program; remove it to start again");
  observer.checkpoint = kept;
  how.tolerance = 1e-7;
  EXPECT_EQ(simulate(system, system.initial, how, observer).error().what,
            "belongs to another run (another scene, start or settings); remove it to start again");
  how.tolerance = settings("dopri5", 1, 1e-2).tolerance;
  how.spectral_radius = 0.5;
  const auto other_radius = simulate(system, system.initial, how, observer);
  ASSERT_FALSE(other_radius);
  EXPECT_EQ(other_radius.error().what,
            "belongs to another run (another scene, start or settings); remove it to start again");
  how.method = "cvode";
  EXPECT_NE(simulate(system, system.initial, how, observer).error().what.find("no checkpoint can store"),
            std::string::npos);
}

// Checkpoints written on the way do not change the run.
TEST(Checkpoint, WritingItChangesNoResult) {
  const System system = compiled(chain(3, true, 0.5));
  const SimulationSettings how = rows_every(settings("dop853", 1, 1e-2, 1e-9), 0.1);
  const Trajectory whole = need(simulate(system, system.initial, how));
  Observer observer;
  std::vector<std::string> kept;
  observer.keep = [&](const std::string& checkpoint) { kept.push_back(checkpoint); };
  observer.keep_due = [] { return true; };
  EXPECT_TRUE(bytes_of(need(simulate(system, system.initial, how, observer))) == bytes_of(whole));
  ASSERT_GT(kept.size(), 3u);
  for (std::size_t i = 0; i < kept.size(); i += 3) {
    Observer later;
    later.checkpoint = kept[i];
    EXPECT_TRUE(bytes_of(need(simulate(system, system.initial, how, later))) == bytes_of(whole)) << i;
  }
}

}  // namespace
}  // namespace borelli::test
